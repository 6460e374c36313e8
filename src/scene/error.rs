//! Why a scene is refused, and where.

use std::fmt;
use std::ops::Range;

use thiserror::Error;

use super::expression::ExpressionError;
use super::mesh_file::MeshFileError;
use super::significant::{brief, significant};
use super::tables::MOST_STEPS;

/// Characters of a line that an error shows at most.
const EXCERPT_WIDTH: usize = 96;
/// Characters of a user's word that a message repeats at most.
const QUOTE_WIDTH: usize = 60;

/// Why a scene is refused, and where.
///
/// Printed, it says the place, what is wrong, what is allowed, and shows the line:
///
/// ```text
/// my.toml:3:1: unknown key 'penality' in [area]; did you mean 'penalty'? Allowed: target, penalty
///   |
/// 3 | penality = 1e-3
///   | ^^^^^^^^
/// ```
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{place}: {problem}\n{}", place.excerpt)]
pub struct SceneError {
    /// Where.
    pub place: Box<Place>,
    /// Why.
    pub problem: Box<Problem>,
}

impl SceneError {
    /// `problem`, in the bytes `range` of `text`.
    pub(super) fn new(origin: &Origin, text: &str, range: Range<usize>, problem: Problem) -> Self {
        Self {
            place: Box::new(Place::new(origin, text, range)),
            problem: Box::new(problem),
        }
    }

    /// Whether it is about this override.
    pub(crate) fn is_of_override(&self, argument: &str) -> bool {
        let mut lines = argument.split('\n');
        self.place.origin == Origin::Override
            && lines.any(|line| Shortened(line).to_string() == self.place.content)
    }
}

/// What is wrong with a scene.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Problem {
    /// The text is not TOML.
    #[error("this is not valid TOML: {message}")]
    Syntax {
        /// What the parser of TOML says.
        message: String,
    },
    /// An override is not of the form `KEY=VALUE`.
    #[error("an override is KEY=VALUE, such as time.step=2e-7: {reason}")]
    Override {
        /// What is missing.
        reason: &'static str,
    },
    /// A key that no scene has.
    #[error("unknown key {} {}{}{} Allowed: {}", Quoted(key), inside(table), did_you_mean(near.map(Quoted)),
        elsewhere_words(*elsewhere), allowed.join(", "))]
    UnknownKey {
        /// The key.
        key: String,
        /// The table it stands in; empty at the top level.
        table: String,
        /// The key that was probably meant.
        near: Option<&'static str>,
        /// A table that does have this key.
        elsewhere: Option<&'static str>,
        /// The keys that this table has.
        allowed: Vec<&'static str>,
    },
    /// A key that belongs to another kind of the same table.
    #[error("{} does not belong to {owner}; allowed: {}", Quoted(key), allowed.join(", "))]
    MisplacedKey {
        /// The key.
        key: String,
        /// What was chosen, such as `shape = "circle"`.
        owner: String,
        /// The keys that it has.
        allowed: Vec<&'static str>,
    },
    /// A key that must be there.
    #[error("{owner} needs the key '{key}'")]
    MissingKey {
        /// The key.
        key: &'static str,
        /// What needs it.
        owner: String,
    },
    /// The transform of the grid was asked for where it does not apply.
    #[error(
        "solver.linear = \"transform\" needs mesh.kind = \"structured\" with mesh.jitter = 0, and domain.boundary = \"natural\"; leave it out, or take \"factor\""
    )]
    TransformDoesNotApply,
    /// An outline that reaches the axis of rotation is not its own mirror image there.
    #[error(
        "by rotation (domain.geometry = \"axisymmetric\") an outline that reaches the axis x = 0 must be its own mirror image there: \
         put its center on the axis, such as [0.0, 0.5], and give an angle of 0 or 90 degrees (of a stomatocyte 0 or 180); or keep it off the axis, where it is a ring"
    )]
    AskewOnAxis,
    /// A field across the axis of rotation.
    #[error(
        "by rotation (domain.geometry = \"axisymmetric\") a field can only be along the axis: field.angle must be 90 or -90, not {}",
        brief(*angle)
    )]
    FieldAcrossAxis {
        /// The angle in degrees.
        angle: f64,
    },
    /// A mesh beyond the axis of rotation.
    #[error(
        "by rotation (domain.geometry = \"axisymmetric\") x is the radius: the mesh has a node at x = {}, and none may be at x < 0",
        brief(*x)
    )]
    MeshBeyondAxis {
        /// Where.
        x: f64,
    },
    /// The shifted Laplacians were asked for where they do not apply.
    #[error(
        "solver.linear = \"shifted\" needs domain.boundary = \"natural\"; leave it out, or take \"factor\""
    )]
    ShiftedDoesNotApply,
    /// Two keys of which only one can be there.
    #[error("{first} and {second} exclude each other: give one of them")]
    Conflict {
        /// The one.
        first: &'static str,
        /// The other.
        second: &'static str,
    },
    /// A key that is given twice, as `"a.b"` and within a table, say.
    #[error("{key} is given more than once")]
    Repeated {
        /// The key with its table.
        key: String,
    },
    /// A value of another type.
    #[error("{key} must be {expected}, not {found}")]
    WrongType {
        /// The key with its table.
        key: String,
        /// What is wanted.
        expected: String,
        /// What stands there.
        found: &'static str,
    },
    /// A value of the right type that makes no sense.
    #[error("{key} must be {allowed}, not {}", Shortened(found))]
    OutOfRange {
        /// The key with its table.
        key: String,
        /// What would make sense.
        allowed: String,
        /// The value as it is written.
        found: String,
    },
    /// A word that is none of the choices.
    #[error("{key} cannot be {}{} Allowed: {}", Quoted(found), did_you_mean(near.map(Quoted)),
        allowed.join(", "))]
    UnknownChoice {
        /// The key with its table.
        key: String,
        /// The word.
        found: String,
        /// The choice that was probably meant.
        near: Option<&'static str>,
        /// The choices.
        allowed: Vec<&'static str>,
    },
    /// Δt cannot be given and chosen.
    #[error("time.step keeps Δt, time.tolerance has it chosen: give one of them, not both")]
    StepAndTolerance,
    /// More steps than can be counted.
    #[error(
        "time.end = {end:?} and time.step = {step:?} make more than {MOST_STEPS:e} steps, more than can be counted: raise \
         time.step, or lower time.end"
    )]
    TooManySteps {
        /// T.
        end: f64,
        /// Δt.
        step: f64,
    },
    /// A mesh cannot be given and chosen.
    #[error(
        "accuracy has a mesh of the unit square made: give one of accuracy and [mesh], not both; --accuracy takes the place \
         of any mesh but that of a file"
    )]
    AccuracyAndMesh,
    /// Nor can steps.
    #[error(
        "accuracy has the steps chosen: give one of accuracy and time.step, time.tolerance, time.scheme, not both"
    )]
    AccuracyAndSteps,
    /// With so few nodes there is no interface.
    #[error(
        "the interface would have fewer than two edges: the largest error that means anything is accuracy = {}",
        significant(*largest, 2)
    )]
    AccuracyTooLow {
        /// The largest.
        largest: f64,
    },
    /// The edges for this error are shorter than a mesh may have.
    #[error(
        "the mesh would have edges shorter than {edge}: the least error that can be had is accuracy = {}",
        significant(*least, 2)
    )]
    AccuracyTooHigh {
        /// The shortest edge.
        edge: f64,
        /// The least error.
        least: f64,
    },
    /// There is nothing to anchor.
    #[error(
        "anchoring.kind = \"{kind}\" needs a director to anchor, and the scene has no [nematic]; \
         add that table, or take anchoring.kind = \"none\", or no [anchoring] (--set anchoring=false)"
    )]
    AnchoringWithoutNematic {
        /// The anchoring that the scene asks for.
        kind: &'static str,
    },
    /// There is nothing for an effect on the director to act on.
    #[error(
        "[{table}] acts on the director, and the scene has no [nematic]; add that table, or take \
         [{table}] away (--set {table}=false)"
    )]
    DirectorWithoutNematic {
        /// The effect's table.
        table: &'static str,
    },
    /// A change of what no scene has.
    #[error("unknown parameter {}{} A change can set: {}", Quoted(key), did_you_mean(near.as_deref().map(Quoted)), allowed.join(", "))]
    UnknownParameter {
        /// The parameter.
        key: String,
        /// The one that was probably meant.
        near: Option<String>,
        /// Those that can change.
        allowed: Vec<String>,
    },
    /// A change of what cannot change.
    #[error("{} cannot change while a run goes. A change can set: {}", Quoted(key), allowed.join(", "))]
    FixedParameter {
        /// The parameter.
        key: String,
        /// Those that can change.
        allowed: Vec<String>,
    },
    /// A change to values from a file.
    #[error(
        "{key} cannot change to values from a file while a run goes: give a number or a formula"
    )]
    ChangeToFile {
        /// The parameter.
        key: String,
    },
    /// A change of an effect on the director, where there is none.
    #[error(
        "a change of {key} needs a director, and the scene has no [nematic]: add that table; a change cannot bring a director in"
    )]
    ChangeWithoutDirector {
        /// The parameter.
        key: String,
    },
    /// A ramp that is not from a number to a number.
    #[error(
        "over = {} makes a ramp from number to number, and {key} {reason}: leave 'over' out, set {key} in a [[change]] of its own, or do without changes (change = [])",
        brief(*over)
    )]
    RampWithoutNumbers {
        /// The parameter.
        key: String,
        /// The length of the ramp.
        over: f64,
        /// What is in the way.
        reason: &'static str,
    },
    /// A formula that cannot be understood or is not finite.
    #[error("{key}: {error}")]
    Expression {
        /// The key with its table.
        key: String,
        /// What is wrong.
        error: ExpressionError,
    },
    /// A file that cannot be read.
    #[error("{key}: the file {} cannot be read: {reason}", Quoted(path))]
    UnreadableFile {
        /// The key with its table.
        key: String,
        /// The path as the scene gives it.
        path: String,
        /// What the system says.
        reason: String,
    },
    /// A line of a file of nodal values that does not hold as many finite numbers as it must.
    #[error("a line must hold {} ({key}); {} is not", numbers(*columns),
        Quoted(found))]
    NodalLine {
        /// The key with its table.
        key: String,
        /// Numbers a line.
        columns: usize,
        /// The line or the word.
        found: String,
    },
    /// A file of nodal values for another mesh.
    #[error(
        "{key} must have a line for each of the {nodes} nodes of the mesh, {mesh}; this file has {}",
        if *found > *nodes { "more".to_owned() } else { found.to_string() }
    )]
    NodalCount {
        /// The key with its table.
        key: String,
        /// Lines with values in the file, or one more than there are nodes if there are more.
        found: usize,
        /// What the mesh has.
        nodes: usize,
        /// Which mesh that is.
        mesh: String,
    },
    /// A file that is no mesh, or none that can be used.
    #[error("the mesh {}, {error}", Quoted(path))]
    MeshFile {
        /// The path as the scene gives it.
        path: String,
        /// What is wrong, and where.
        error: MeshFileError,
    },
    /// The scene that a plan names cannot be had.
    #[error("the plan's scene: {reason}")]
    PlanScene {
        /// Why.
        reason: String,
    },
    /// There is nothing random to repeat.
    #[error(
        "repeat needs a seed, and the scene of point {point} has none; name its keys, as in \
         repeat = {{ count = {count}, seeds = [\"noise.seed\"] }}"
    )]
    NoSeed {
        /// Which point.
        point: usize,
        /// How often it is to be repeated.
        count: u64,
    },
    /// A plan of more points than can be handled.
    #[error("the plan has {count} points; at most {most} can be handled")]
    TooManyPoints {
        /// How many.
        count: usize,
        /// How many there may be.
        most: usize,
    },
    /// A column of a sweep's table with the name of another.
    #[error(
        "the table has a column {} already: give this one another name",
        Quoted(name)
    )]
    TakenColumn {
        /// The name.
        name: String,
    },
    /// A mesh that is to be finer about a membrane that is not known beforehand.
    #[error(
        "mesh.refine is about the initial membrane, and vesicle.shape gives no outline: leave it out, \
         or take a shape such as \"circle\""
    )]
    RefineWithoutOutline,
    /// Values at the nodes of a mesh whose nodes change.
    #[error(
        "the nodes of a mesh that follows the membrane change, and {} has values at nodes ({key}): take \
         another mesh.kind, or a formula in place of the file",
        Quoted(path)
    )]
    NodalValuesOnAdaptiveMesh {
        /// The key that names the file, with its table.
        key: String,
        /// The file.
        path: String,
    },
}

/// Who wrote a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// A file or a preset, as the caller names it: `my.toml`, `preset case3`.
    Text(String),
    /// An argument `--set KEY=VALUE`.
    Override,
}

/// A place in a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Who wrote the text.
    pub origin: Origin,
    /// Counted from 1.
    pub line: usize,
    /// In characters, counted from 1.
    pub column: usize,
    /// The line, numbered, with a caret under the place.
    pub excerpt: String,
    /// The line, shortened, for the header of an override.
    content: String,
}

impl Place {
    fn new(origin: &Origin, text: &str, range: Range<usize>) -> Self {
        let start = text.floor_char_boundary(range.start);
        let end = text.floor_char_boundary(range.end.max(start));
        let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
        let line = 1 + text[..line_start].matches('\n').count();
        let before = text[line_start..start].chars().count();
        let width = text[start..end.clamp(start, line_end)]
            .chars()
            .count()
            .max(1);

        // A line of thousands of characters is shown around the place only.
        let skipped = if before + width <= EXCERPT_WIDTH {
            0
        } else {
            before.saturating_sub(EXCERPT_WIDTH / 4)
        };
        let shown = printable(
            text[line_start..line_end].chars().skip(skipped),
            EXCERPT_WIDTH,
        );
        let gutter = match origin {
            Origin::Text(_) => line.to_string(),
            Origin::Override => "--set".to_owned(),
        };
        let margin = " ".repeat(gutter.chars().count());
        let indent = " ".repeat(before - skipped);
        let carets = "^".repeat(width.min(EXCERPT_WIDTH));
        let excerpt = format!(
            "{margin} |\n{gutter} | {}\n{margin} | {indent}{carets}",
            shown.trim_end()
        );
        let content = Shortened(&text[line_start..line_end]).to_string();
        Self {
            origin: origin.clone(),
            line,
            column: before + 1,
            excerpt,
            content,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.origin {
            Origin::Text(name) => write!(f, "{name}:{}:{}", self.line, self.column),
            Origin::Override => write!(f, "--set {}", self.content),
        }
    }
}

/// The first `width` characters, one column each: nothing that moves a terminal's cursor.
fn printable(text: impl Iterator<Item = char>, width: usize) -> String {
    text.take(width)
        .map(|character| match character {
            '\t' | '\r' => ' ',
            character if character.is_control() => char::REPLACEMENT_CHARACTER,
            character => character,
        })
        .collect()
}

/// A user's word, safe to print and not too long.
struct Shortened<'a>(&'a str);

impl fmt::Display for Shortened<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&printable(self.0.chars(), QUOTE_WIDTH))?;
        if self.0.chars().nth(QUOTE_WIDTH).is_some() {
            f.write_str("…")
        } else {
            Ok(())
        }
    }
}

/// A user's word in quotes.
pub(super) struct Quoted<'a>(pub(super) &'a str);

impl fmt::Display for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "'{}'", Shortened(self.0))
    }
}

/// The table that a key stands in.
fn inside(table: &str) -> String {
    match table {
        "" => "at the top level".to_owned(),
        table if table.contains('.') => format!("in {table}"),
        table => format!("in [{table}]"),
    }
}

/// The end of a first half sentence.
pub(super) fn did_you_mean(words: Option<impl fmt::Display>) -> String {
    words.map_or_else(
        || ".".to_owned(),
        |words| format!("; did you mean {words}?"),
    )
}

/// Where a key would be right.
fn elsewhere_words(table: Option<&str>) -> String {
    table.map_or_else(String::new, |table| format!(" It is a key of [{table}]."))
}

/// A number of finite numbers.
fn numbers(count: usize) -> String {
    format!("{count} finite number{}", if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(text: &str, range: Range<usize>) -> Place {
        Place::new(&Origin::Text("a.toml".to_owned()), text, range)
    }

    #[test]
    fn lines_and_columns_count_characters_from_one() {
        let place = place("ä = 1\nöö = 2\n", 14..15);
        assert_eq!((place.line, place.column), (2, 6));
        assert_eq!(place.excerpt, "  |\n2 | öö = 2\n  |      ^");
    }

    #[test]
    fn any_range_has_a_place() {
        for text in ["", "\n", "é", "a\r\nb", "\u{feff}x"] {
            for start in 0..6 {
                for end in 0..6 {
                    assert!(place(text, start..end).line >= 1);
                }
            }
        }
    }

    #[test]
    fn nothing_reaches_the_terminal_raw() {
        let place = place("a = \"\u{1b}[2J\"\t", 4..9);
        assert!(!place.excerpt.contains('\u{1b}'), "{}", place.excerpt);
        assert!(!Quoted("\u{1b}]0;x").to_string().contains('\u{1b}'));
    }

    #[test]
    fn a_long_line_is_cut_around_the_place() {
        let text = format!("{}wrong{}", "a".repeat(5000), "b".repeat(5000));
        let place = place(&text, 5000..5005);
        let lines: Vec<&str> = place.excerpt.lines().collect();
        assert!(
            lines[1].chars().count() <= EXCERPT_WIDTH + 4,
            "{}",
            lines[1]
        );
        let caret = lines[2].find('^').expect("a caret");
        assert_eq!(&lines[1][caret..caret + 5], "wrong");
        assert_eq!(place.column, 5001);
    }
}
