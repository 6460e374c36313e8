//! Tables that another program has rewritten since the run wrote them, or that were damaged: brought back
//! as far as that is possible, with words on what was found.

use super::RecordError;
use super::lenient::{Difference, LenientTable};
use super::read::LARGEST;
use super::table::Extent;
use super::whole::read_text;
use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;

/// Damages that are described one by one; more of them are counted.
const DESCRIBED: usize = 3;

/// What is to stand in place of a table.
#[derive(Debug)]
pub(super) struct Repaired {
    /// The whole file.
    pub text: String,
    /// How many rows it has.
    pub rows: u64,
    /// What is to be reported.
    pub remarks: Vec<String>,
}

/// A row as vesica writes it.
struct Row {
    step: f64,
    t: f64,
    /// The line that it stood in.
    line: usize,
    /// Where it is in the text of all rows.
    place: Range<usize>,
    is_ended: bool,
}

/// Reads what a table had when it went as far as `extent`.
///
/// # Errors
/// [`RecordError::Read`]; [`RecordError::NoColumn`]; [`RecordError::Short`], where its last rows are not
/// there.
pub(super) fn repair(path: &Path, extent: &Extent) -> Result<Repaired, RecordError> {
    let text = read_text(path, LARGEST).map_err(|reason| RecordError::Read {
        path: path.to_owned(),
        reason,
    })?;
    let short = |rows: usize| RecordError::Short {
        path: path.to_owned(),
        rows: rows as u64,
        wanted: extent.rows,
    };
    let table = LenientTable::new(&text).ok_or_else(|| short(0))?;
    let mut places = Vec::with_capacity(extent.columns.len());
    for name in &extent.columns {
        let place = table.columns.iter().position(|column| column == name);
        places.push(place.ok_or_else(|| RecordError::NoColumn {
            path: path.to_owned(),
            name: name.clone(),
        })?);
    }
    let Content {
        lines,
        mut rows,
        mut damages,
        mut differences,
    } = Content::read(table, &places, &extent.columns);

    // Later rows are of what the run did after its checkpoint; no row is before one whose step is earlier.
    rows.retain(|row| extent.last_step.is_some_and(|last| row.step <= last as f64));
    if !rows.is_sorted_by(|one, other| one.step <= other.step) {
        differences.insert(Difference::Order);
        rows.sort_by(|one, other| one.step.total_cmp(&other.step));
    }
    let assembled = |rows: &[Row]| {
        let mut text = extent.columns.join(",") + "\n";
        rows.iter().for_each(|row| {
            text.push_str(&lines[row.place.clone()]);
            text.push('\n');
        });
        text
    };
    let mut whole = assembled(&rows);
    let is_exact = crc32fast::hash(whole.as_bytes()) == extent.checksum;
    let mut remarks = Vec::new();
    if !is_exact {
        // A line without an end may have been cut in the midst of a number.
        rows.retain(|row| row.is_ended);
        rows.dedup_by(|later, earlier| {
            let is_again = later.step == earlier.step;
            if is_again {
                damages.push(format!(
                    "line {} is left out: step {} stands in line {} too",
                    later.line, later.step, earlier.line
                ));
            }
            is_again
        });
        if rows.last().map(|row| row.step as u64) != extent.last_step {
            return Err(short(rows.len()));
        }
        damages.extend(backward_times(&rows));
        damages.extend(missing_rows(&rows, extent.rows));
        whole = assembled(&rows);
        if damages.is_empty() {
            damages.push(
                "its numbers are not those that the run wrote (a spreadsheet keeps 15 digits of \
                 them), and stay as they stand"
                    .to_owned(),
            );
        }
        remarks.push(damage_words(path, &damages));
    }
    if !differences.is_empty() {
        let words: Vec<&str> = differences.into_iter().map(Difference::words).collect();
        let numbers = match is_exact {
            true => "; all its numbers are there",
            false => "",
        };
        remarks.push(format!(
            "{} had been rewritten by another program, with {}: it is brought back to its form{numbers}",
            path.display(),
            words.join(", ")
        ));
    }
    Ok(Repaired {
        text: whole,
        rows: rows.len() as u64,
        remarks,
    })
}

/// The rows of a table.
struct Content {
    /// The text of all rows.
    lines: String,
    rows: Vec<Row>,
    /// What is wrong, in words.
    damages: Vec<String>,
    differences: BTreeSet<Difference>,
}

impl Content {
    /// Reads the columns that stand in these places.
    fn read(mut table: LenientTable<'_>, places: &[usize], names: &[String]) -> Content {
        let mut lines = String::new();
        let (mut rows, mut damages) = (Vec::new(), Vec::new());
        while let Some(line) = table.next() {
            let begin = lines.len();
            let cell = |place: usize| line.cells.get(place).map_or("", |cell| cell.as_ref());
            let number = line.number;
            let step = places.first().and_then(|place| table.value(cell(*place)));
            let Some(step) = step.filter(|step| step.is_finite()) else {
                damages.push(format!("line {number} is left out: it has no step"));
                continue;
            };
            if line.is_ended && line.cells.len() < table.columns.len() {
                damages.push(format!(
                    "line {number} has {} cells of {}, and the others are left empty",
                    line.cells.len(),
                    table.columns.len()
                ));
            }
            for (index, (place, name)) in places.iter().zip(names).enumerate() {
                if index > 0 {
                    lines.push(',');
                }
                match table.canonical(cell(*place)) {
                    Some(text) => lines.push_str(&text),
                    None => damages.push(format!(
                        "line {number}, column {name} had {:?}, which is no number, and is left empty",
                        cell(*place)
                    )),
                }
            }
            let t = places.get(1).and_then(|place| table.value(cell(*place)));
            rows.push(Row {
                step,
                t: t.unwrap_or(f64::NAN),
                line: number,
                place: begin..lines.len(),
                is_ended: line.is_ended,
            });
        }
        let mut differences = table.differences().clone();
        // Columns at the right may be those of an effect that came after the checkpoint.
        if !places.iter().copied().eq(0..places.len()) {
            differences.insert(Difference::Columns);
        }
        Content {
            lines,
            rows,
            damages,
            differences,
        }
    }
}

/// Where the time does not grow with the step.
fn backward_times(rows: &[Row]) -> Vec<String> {
    let pairs = rows.windows(2);
    // A time that is no number counts.
    let is_less = Some(Ordering::Less);
    let wrong = pairs.filter(|pair| pair[0].t.partial_cmp(&pair[1].t) != is_less);
    wrong
        .map(|pair| {
            format!(
                "line {} has t = {}, after t = {} in line {}",
                pair[1].line, pair[1].t, pair[0].t, pair[0].line
            )
        })
        .collect()
}

/// How many rows are missing, and where the first of them is.
fn missing_rows(rows: &[Row], wanted: u64) -> Option<String> {
    let missing = wanted.checked_sub(rows.len() as u64)?;
    let distance = |pair: &[Row]| pair[1].step - pair[0].step;
    let stride = rows.windows(2).map(distance).fold(f64::INFINITY, f64::min);
    let gap = rows.windows(2).find(|pair| distance(pair) > stride);
    let place = gap.map_or_else(
        || "before the first".to_owned(),
        |pair| format!("between the steps {} and {}", pair[0].step, pair[1].step),
    );
    (missing > 0)
        .then(|| format!("{missing} of {wanted} rows are missing, the first of them {place}"))
}

fn damage_words(path: &Path, damages: &[String]) -> String {
    let described = &damages[..damages.len().min(DESCRIBED)];
    let more = match damages.len() - described.len() {
        0 => String::new(),
        more => format!("; and {more} more"),
    };
    format!(
        "{} is damaged: {}{more}",
        path.display(),
        described.join("; ")
    )
}
