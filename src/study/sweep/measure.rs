//! Numbers of a run for a column of the table: of its last row, of all rows, or of an event.

use crate::record::{Columns, EventRecord, HISTORY_COLUMNS};

/// The columns of shape.csv that history.csv does not have.
const SHAPE: [&str; 3] = ["length", "waist", "width"];

/// A number of a run, or a ratio of two.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    numerator: Term,
    denominator: Option<Term>,
}

#[derive(Debug, Clone, PartialEq)]
enum Term {
    /// Of a column.
    Of(Reduction, String),
    /// t of the first row at which a column is below a value, or above it.
    FirstTime {
        column: String,
        is_below: bool,
        value: f64,
    },
    /// t of the first event of a kind.
    Event(String),
}

/// What is made of the rows of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reduction {
    First,
    Last,
    Min,
    Max,
    TimeOfMin,
    TimeOfMax,
}

const REDUCTIONS: [(&str, Reduction); 6] = [
    ("first", Reduction::First),
    ("last", Reduction::Last),
    ("min", Reduction::Min),
    ("max", Reduction::Max),
    ("time_of_min", Reduction::TimeOfMin),
    ("time_of_max", Reduction::TimeOfMax),
];

/// A text that is not a measure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NoMeasure {
    /// The column that there is not, if it is that.
    pub column: Option<String>,
}

impl Measure {
    /// What a measure may be.
    pub const WORDS: &str = "a column (its last value), first(…), last(…), min(…), max(…), time_of_min(…) or \
        time_of_max(…) of a column, time(COLUMN < VALUE), event(KIND), or one of them / another";

    /// The columns that every run has.
    pub fn columns() -> impl Iterator<Item = &'static str> {
        HISTORY_COLUMNS.into_iter().chain(SHAPE)
    }

    /// Reads `waist`, `min(E_total)`, `time(waist < 0.1)`, `event(parameters-changed)`, or a ratio `waist / length`.
    ///
    /// # Errors
    /// [`NoMeasure`].
    pub fn parse(text: &str) -> Result<Measure, NoMeasure> {
        let mut parts = text.split('/');
        let mut term = || parts.next().map(Term::parse).transpose();
        let numerator = term()?.ok_or(NoMeasure { column: None })?;
        let denominator = term()?;
        match parts.next() {
            Some(_) => Err(NoMeasure { column: None }),
            None => Ok(Measure {
                numerator,
                denominator,
            }),
        }
    }

    /// Its value in a run; `None` where the run does not have it.
    pub fn of(&self, history: &Columns, events: &[EventRecord]) -> Option<f64> {
        let numerator = self.numerator.of(history, events)?;
        let value = match &self.denominator {
            Some(denominator) => numerator / denominator.of(history, events)?,
            None => numerator,
        };
        Some(value).filter(|value| !value.is_nan())
    }

    /// Whether it is a time on the clock, which no two runs have alike.
    pub fn is_clock(&self) -> bool {
        let is_wall = |term: &Term| matches!(term, Term::Of(_, column) if column == "wall");
        is_wall(&self.numerator) && self.denominator.is_none()
    }
}

impl Term {
    fn parse(text: &str) -> Result<Term, NoMeasure> {
        let text = text.trim();
        let Some((function, rest)) = text.split_once('(') else {
            return Ok(Term::Of(Reduction::Last, column(text)?));
        };
        let no_measure = NoMeasure { column: None };
        let argument = rest.strip_suffix(')').ok_or(no_measure.clone())?.trim();
        let function = function.trim();
        if let Some((_, reduction)) = REDUCTIONS.iter().find(|(name, _)| *name == function) {
            return Ok(Term::Of(*reduction, column(argument)?));
        }
        match function {
            "event" if !argument.is_empty() => Ok(Term::Event(argument.to_owned())),
            "time" => {
                let is_below = argument.contains('<');
                let (name, value) = argument.split_once(['<', '>']).ok_or(no_measure.clone())?;
                let value: f64 = value.trim().parse().map_err(|_| no_measure)?;
                Ok(Term::FirstTime {
                    column: column(name.trim())?,
                    is_below,
                    value,
                })
            }
            _ => Err(no_measure),
        }
    }

    fn of(&self, history: &Columns, events: &[EventRecord]) -> Option<f64> {
        let times = history.column("t")?;
        match self {
            Term::Event(kind) => events.iter().find(|it| it.kind == *kind).map(|it| it.t),
            Term::FirstTime {
                column,
                is_below,
                value,
            } => {
                let values = history.column(column)?;
                let row = values.iter().position(|it| match is_below {
                    true => it < value,
                    false => it > value,
                })?;
                times.get(row).copied()
            }
            Term::Of(reduction, column) => {
                let values = history.column(column)?;
                let numbers = values.iter().enumerate().filter(|(_, it)| !it.is_nan());
                let by_value = |a: &(usize, &f64), b: &(usize, &f64)| a.1.total_cmp(b.1);
                match reduction {
                    Reduction::First => values.first().copied(),
                    Reduction::Last => values.last().copied(),
                    Reduction::Min => numbers.min_by(by_value).map(|(_, value)| *value),
                    Reduction::Max => numbers.max_by(by_value).map(|(_, value)| *value),
                    Reduction::TimeOfMin => times.get(numbers.min_by(by_value)?.0).copied(),
                    Reduction::TimeOfMax => times.get(numbers.max_by(by_value)?.0).copied(),
                }
            }
        }
    }
}

/// The name of a column that a run may have: an effect's energy is `E_` and its name.
fn column(name: &str) -> Result<String, NoMeasure> {
    let is_known = Measure::columns().any(|known| known == name) || name.starts_with("E_");
    match is_known {
        true => Ok(name.to_owned()),
        false => Err(NoMeasure {
            column: Some(name.to_owned()),
        }),
    }
}
