//! Tables that another program has rewritten since the run wrote them, or that were damaged: brought back
//! as far as that is possible, with words on what was found.

use super::Number;
use super::lenient::{Difference, Differences, LenientTable};
use super::shortened::shortened;
use super::table::Extent;
use super::table_checks::Checks;
use std::ops::Range;
use std::path::Path;

/// Damages that are described one by one; more of them are counted.
const DESCRIBED: usize = 3;

/// What replaces a table.
#[derive(Debug)]
pub(super) struct Repaired {
    /// The whole file.
    pub text: String,
    /// How many rows it has.
    pub rows: u64,
    /// What is reported.
    pub remarks: Vec<String>,
    /// Whether anything of the file is left out that the run may not have written.
    pub leaves_out: bool,
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

/// Reads what a table had when it went as far as `extent`, or what is left of it; `None`: it has no header
/// by which its rows would be known.
pub(super) fn repair(path: &Path, text: &str, extent: &Extent) -> Option<Repaired> {
    let table = LenientTable::new(text)?;
    let place = |name: &String| table.columns.iter().position(|column| column == name);
    let places: Vec<Option<usize>> = extent.columns.iter().map(place).collect();
    // A row is known by its step.
    places.first().copied().flatten()?;
    let Content {
        lines,
        mut rows,
        damages: mut of_lines,
        mut differences,
        mut leaves_out,
    } = Content::read(table, &places, extent);

    // No row is before one whose step is earlier.
    if !rows.is_sorted_by(|one, other| one.step <= other.step) {
        differences.note(Difference::Order);
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
    let is_exact = |whole: &str| crc32fast::hash(whole.as_bytes()) == extent.checksum;
    let mut whole = assembled(&rows);
    let mut damages = Vec::new();
    if is_exact(&whole) {
        if rows.iter().any(|row| !row.is_ended) {
            differences.note(Difference::NoLastEnd);
        }
    } else {
        // A line without an end may have been cut in the midst of a number.
        rows.retain(|row| {
            if !row.is_ended {
                of_lines.push(format!("line {} is cut short, and left out", row.line));
            }
            row.is_ended
        });
        // Where the anchoring was switched in the app a step has two rows.
        let mut extra = (rows.len() as u64).saturating_sub(extent.rows);
        rows.dedup_by(|later, earlier| {
            let is_same = lines[later.place.clone()] == lines[earlier.place.clone()];
            let is_again = later.step == earlier.step && (is_same || extra > 0);
            if is_again {
                extra = extra.saturating_sub(1);
                of_lines.push(format!(
                    "line {} is left out: step {} stands in line {} too",
                    later.line, later.step, earlier.line
                ));
                leaves_out |= !is_same;
            }
            is_again
        });
        whole = assembled(&rows);
        damages.extend(missing_rows(&rows, extent));
        damages.extend(missing_columns(&places, &extent.columns));
        of_lines.extend(backward_times(&rows));
    }
    damages.extend(of_lines);
    let is_exact = is_exact(&whole);
    if damages.is_empty() && !is_exact {
        damages.push(changed_numbers(&rows, &lines, extent));
    }
    let numbers = match is_exact {
        true => "; all its numbers are there",
        false => "",
    };
    let mut remarks = Vec::new();
    if !damages.is_empty() {
        remarks.push(damage_words(path, &damages) + numbers);
    }
    if !differences.is_empty() {
        remarks.push(format!(
            "{} had been rewritten by another program, with {}: it is brought back to its form{numbers}",
            path.display(),
            differences.words()
        ));
    }
    Some(Repaired {
        text: whole,
        rows: rows.len() as u64,
        remarks,
        leaves_out,
    })
}

/// The rows of a table up to where it must go.
struct Content {
    /// The text of all rows.
    lines: String,
    rows: Vec<Row>,
    /// What is wrong, in words.
    damages: Vec<String>,
    differences: Differences,
    leaves_out: bool,
}

impl Content {
    /// Reads the columns in these places.
    fn read(mut table: LenientTable<'_>, places: &[Option<usize>], extent: &Extent) -> Content {
        let width = table.columns.len();
        let is_further = |place: &usize| !places.contains(&Some(*place));
        let further: Vec<usize> = (0..width).filter(is_further).collect();
        let mut has_further = false;
        let mut lines = String::new();
        let (mut rows, mut damages, mut leaves_out) = (Vec::new(), Vec::new(), false);
        while let Some(line) = table.next() {
            let begin = lines.len();
            let cell = |place: Option<usize>| {
                let cell = place.and_then(|place| line.cells.get(place));
                cell.map_or("", |cell| cell.as_ref())
            };
            let number = line.number;
            let step = table.value(cell(places[0]));
            let Some(step) = step.filter(|step| *step >= 0.0 && step.fract() == 0.0) else {
                damages.push(match line.is_ended {
                    true => {
                        leaves_out = true;
                        let first = line.cells.iter().find(|cell| !cell.is_empty());
                        let first = first.map_or("", |cell| cell.as_ref());
                        format!(
                            "line {number} is left out: it has no step, and begins with {:?}",
                            shortened(first)
                        )
                    }
                    false => format!("line {number} is cut short, and left out"),
                });
                continue;
            };
            // Later rows are of what the run did after its checkpoint.
            if extent.last_step.is_none_or(|last| step > last as f64) {
                continue;
            }
            let cells = line.cells.len();
            if line.is_ended && cells < width {
                damages.push(format!(
                    "line {number} has {cells} cells of {width}, and the others are left empty"
                ));
            }
            if cells > width {
                leaves_out = true;
                damages.push(format!(
                    "line {number} has {cells} cells, and those after the first {width} are left out"
                ));
            }
            // A column that the run has begun later is still empty.
            has_further |= further.iter().any(|place| !cell(Some(*place)).is_empty());
            for (index, (place, name)) in places.iter().zip(&extent.columns).enumerate() {
                if index > 0 {
                    lines.push(',');
                }
                match table.canonical(cell(*place), number) {
                    Some(text) => lines.push_str(&text),
                    None => {
                        leaves_out = true;
                        damages.push(format!(
                            "line {number}, column {name} had {:?}, which is no number, and is left \
                             empty",
                            shortened(cell(*place))
                        ));
                    }
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
        if has_further || !places.iter().flatten().is_sorted() {
            differences.note(Difference::Columns);
        }
        Content {
            lines,
            rows,
            damages,
            differences,
            leaves_out: leaves_out || has_further,
        }
    }
}

/// Where the time does not grow with the step.
fn backward_times(rows: &[Row]) -> Vec<String> {
    let pairs = rows.windows(2);
    // A time that is not a number counts.
    let wrong = pairs.filter(|pair| {
        let times = pair[0].t.partial_cmp(&pair[1].t);
        times != Some(pair[0].step.total_cmp(&pair[1].step))
    });
    wrong
        .map(|pair| {
            let [before, after] = [&pair[0], &pair[1]];
            let (t, earlier) = (Number(after.t), Number(before.t));
            format!(
                "line {} has t = {t}, after t = {earlier} in line {}",
                after.line, before.line
            )
        })
        .collect()
}

/// How many rows are missing, and where.
fn missing_rows(rows: &[Row], extent: &Extent) -> Option<String> {
    let wanted = extent.rows;
    let Some(missing) = wanted.checked_sub(rows.len() as u64) else {
        return Some(format!(
            "it has {} rows, and the run wrote {wanted}",
            rows.len()
        ));
    };
    let Some(last) = rows.last() else {
        return (missing > 0).then(|| format!("all {wanted} rows are missing"));
    };
    let distance = |pair: &[Row]| pair[1].step - pair[0].step;
    let distances = rows.windows(2).map(distance);
    let stride = distances
        .filter(|it| *it > 0.0)
        .fold(f64::INFINITY, f64::min);
    let gap = rows.windows(2).find(|pair| distance(pair) > stride);
    // The rows after the last one, where they are as far from each other as the others.
    let to_end = extent.last_step.map_or(0.0, |end| end as f64 - last.step);
    let at_end = if stride.is_finite() {
        to_end / stride
    } else {
        to_end
    };
    let place = match gap {
        Some(pair) => format!(
            "the first of them between the steps {} and {}",
            pair[0].step, pair[1].step
        ),
        None if at_end == 0.0 => "the first ones".to_owned(),
        None if at_end < missing as f64 => "the last ones among them".to_owned(),
        None => "the last ones".to_owned(),
    };
    (missing > 0).then(|| format!("{missing} of {wanted} rows are missing, {place}"))
}

/// Which columns are missing.
fn missing_columns(places: &[Option<usize>], names: &[String]) -> Option<String> {
    let missing = places.iter().zip(names);
    let missing = missing.filter_map(|(place, name)| place.is_none().then_some(name.as_str()));
    let missing: Vec<&str> = missing.collect();
    let named = missing[..missing.len().min(DESCRIBED)].join(", ");
    match missing.len() {
        0 => None,
        1 => Some(format!("the column {named} is missing, and left empty")),
        2..=DESCRIBED => Some(format!("the columns {named} are missing, and left empty")),
        more => Some(format!(
            "{more} columns are missing, and left empty: {named}, …"
        )),
    }
}

/// Which numbers are not those that the run wrote.
fn changed_numbers(rows: &[Row], lines: &str, extent: &Extent) -> String {
    let found = Checks::of(rows.iter().map(|row| &lines[row.place.clone()]));
    let columns = extent.checks.different_columns(&found);
    let names = columns
        .iter()
        .filter_map(|&column| extent.columns.get(column));
    let names: Vec<&str> = names.map(String::as_str).collect();
    let places: Vec<usize> = match extent.checks.different_rows(&found) {
        Some(among) => {
            let end = usize::try_from(among.end)
                .unwrap_or(rows.len())
                .min(rows.len());
            let begin = usize::try_from(among.start).unwrap_or(end).min(end);
            rows[begin..end].iter().map(|row| row.line).collect()
        }
        None => Vec::new(),
    };
    let first = places.iter().min().copied();
    let last = places.iter().max().copied();
    let of_lines = match (first, last) {
        (Some(first), Some(last)) if first == last => format!("line {first}"),
        (Some(first), Some(last)) if last == first + 1 => {
            format!("in the lines {first} and {last}")
        }
        (Some(first), Some(last)) => format!("between the lines {first} and {last}"),
        _ => "in it".to_owned(),
    };
    let of_columns = match &names[..] {
        [] => String::new(),
        [name] => format!(", column {name}"),
        names if names.len() <= DESCRIBED => format!(", columns {}", names.join(", ")),
        names => format!(", {} columns", names.len()),
    };
    let what = match (first == last, &names[..]) {
        (true, [_]) => "the number is not the one that the run wrote, and stays as it stands",
        _ => {
            "numbers are not those that the run wrote (a spreadsheet keeps 15 digits of them), and \
             stay as they stand"
        }
    };
    format!("{of_lines}{of_columns}: {what}")
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
