//! Tables as spreadsheets and editors leave them: with a byte-order mark, CR LF, quoted cells, other
//! separators, blank lines, the header among the rows. They are read as what was meant.

use super::Number;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// The column that every table has, by which its header is known.
pub(super) const STEP: &str = "step";

/// A table that is read line by line.
#[derive(Debug)]
pub(super) struct LenientTable<'a> {
    /// The names of its columns.
    pub columns: Vec<String>,
    separator: char,
    lines: Lines<'a>,
    /// The number of the header's line.
    header: usize,
    differences: Differences,
}

/// A line of it that is not blank.
#[derive(Debug)]
pub(super) struct Line<'a> {
    /// Its number, from 1.
    pub number: usize,
    /// Its cells: as many as there are columns, or what there are.
    pub cells: Vec<Cow<'a, str>>,
    /// Whether the line has an end: the last one of a file that was cut has none.
    pub is_ended: bool,
}

/// In what a table can differ from what vesica writes and yet say the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Difference {
    ByteOrderMark,
    CarriageReturns,
    OnlyCarriageReturns,
    Separator,
    Header,
    Quotes,
    Blanks,
    ExtraCells,
    BlankLines,
    NoLastEnd,
    Numbers,
    Order,
    Columns,
}

impl Difference {
    fn words(self) -> &'static str {
        match self {
            Self::ByteOrderMark => "a byte-order mark",
            Self::CarriageReturns => "CR LF at the ends of lines",
            Self::OnlyCarriageReturns => "CR at the ends of lines",
            Self::Separator => "other separators than commas",
            Self::Header => "its header among the rows",
            Self::Quotes => "quoted cells",
            Self::Blanks => "blanks around cells",
            Self::ExtraCells => "empty cells at the ends of lines",
            Self::BlankLines => "blank lines",
            Self::NoLastEnd => "no end of the last line",
            Self::Numbers => "numbers written in another way",
            Self::Order => "its rows in another order",
            Self::Columns => "its columns in another order, or further ones",
        }
    }
}

/// In what a table differs, and in which lines.
#[derive(Debug, Clone, Default)]
pub(super) struct Differences(BTreeMap<Difference, Option<Places>>);

/// The lines in which a table differs.
#[derive(Debug, Clone, Copy)]
struct Places {
    first: usize,
    last: usize,
    lines: usize,
}

impl Differences {
    /// Notes one of the whole table.
    pub fn note(&mut self, difference: Difference) {
        self.0.insert(difference, None);
    }

    /// Notes one of a line. Lines come in order.
    pub fn note_line(&mut self, difference: Difference, line: usize) {
        let places = self.0.entry(difference).or_insert(Some(Places {
            first: line,
            last: line,
            lines: 1,
        }));
        if let Some(places) = places.as_mut().filter(|places| places.last != line) {
            places.last = line;
            places.lines += 1;
        }
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What and where, in words.
    pub fn words(&self) -> String {
        let words = |(difference, places): (&Difference, &Option<Places>)| {
            let words = difference.words();
            match places {
                None => words.to_owned(),
                Some(Places {
                    first, lines: 1, ..
                }) => format!("{words} (line {first})"),
                Some(Places { first, lines, .. }) => {
                    format!("{words} ({lines} lines, the first is {first})")
                }
            }
        };
        self.0.iter().map(words).collect::<Vec<_>>().join(", ")
    }
}

impl<'a> LenientTable<'a> {
    /// Reads the header: the first line that has the column `step`, or else the first; `None`: it has no
    /// name in it.
    pub fn new(text: &'a str) -> Option<Self> {
        let mut differences = Differences::default();
        let text = match text.strip_prefix('\u{feff}') {
            Some(text) => {
                differences.note(Difference::ByteOrderMark);
                text
            }
            None => text,
        };
        let mut lines = Lines { text, number: 0 };
        let of_spreadsheet = |line: &RawLine<'_>| {
            let word = line.text.get(..4);
            word.is_some_and(|word| word.eq_ignore_ascii_case("sep="))
        };
        if lines.next_if(of_spreadsheet).is_some() {
            differences.note(Difference::Separator);
        }
        while let Some(line) = lines.next_if(|line| line.text.trim().is_empty()) {
            differences.note_line(Difference::BlankLines, line.number);
        }
        let has_step = |line: &RawLine<'_>| {
            let is_step = |cell: &Cow<'_, str>| cell.trim() == STEP;
            line.text.contains(STEP) && split(line.text, separator(line.text)).iter().any(is_step)
        };
        let first = lines.clone().next()?;
        let header = lines.clone().find(has_step).unwrap_or(first);
        if header.number > first.number {
            differences.note_line(Difference::Header, header.number);
        }
        let mut table = Self {
            columns: Vec::new(),
            separator: separator(header.text),
            lines,
            header: header.number,
            differences,
        };
        if table.separator != ',' {
            table.differences.note(Difference::Separator);
        }
        let mut columns: Vec<String> = table.cells(&header).into_iter().map(Cow::into).collect();
        while columns.last().is_some_and(String::is_empty) {
            columns.pop();
            table
                .differences
                .note_line(Difference::ExtraCells, header.number);
        }
        table.columns = columns;
        (!table.columns.is_empty()).then_some(table)
    }

    /// In what it differs from a table of vesica, as far as it was read.
    pub fn differences(&self) -> &Differences {
        &self.differences
    }

    /// The text of a cell of a line as vesica would write it; `None`: it is not a number.
    pub fn canonical(&mut self, cell: &str, line: usize) -> Option<String> {
        if cell.is_empty() {
            return Some(String::new());
        }
        let text = Number(self.value(cell)?).to_string();
        if text != cell {
            self.differences.note_line(Difference::Numbers, line);
        }
        Some(text)
    }

    /// The number in a cell; that of an empty one is NaN.
    pub fn value(&self, cell: &str) -> Option<f64> {
        if cell.is_empty() {
            return Some(f64::NAN);
        }
        // Who separates cells by semicolons may have a comma in the numbers.
        let value = cell.parse().ok();
        value.or_else(|| match self.separator {
            ',' => None,
            _ => cell.replace(',', ".").parse().ok(),
        })
    }

    fn cells(&mut self, line: &RawLine<'a>) -> Vec<Cow<'a, str>> {
        let difference = match line.end {
            End::Unix | End::None => None,
            End::Windows => Some(Difference::CarriageReturns),
            End::OldMac => Some(Difference::OnlyCarriageReturns),
        };
        if let Some(difference) = difference {
            self.differences.note_line(difference, line.number);
        }
        if line.text.contains('"') {
            self.differences.note_line(Difference::Quotes, line.number);
        }
        let mut cells = split(line.text, self.separator);
        for cell in &mut cells {
            let trimmed = cell.trim();
            if trimmed.len() < cell.len() {
                // A line of blanks is reported as a blank one.
                if !trimmed.is_empty() {
                    self.differences.note_line(Difference::Blanks, line.number);
                }
                *cell = match cell {
                    Cow::Borrowed(cell) => Cow::Borrowed(cell.trim()),
                    Cow::Owned(cell) => Cow::Owned(cell.trim().to_owned()),
                };
            }
        }
        cells
    }
}

impl<'a> Iterator for LenientTable<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        loop {
            let line = self.lines.next()?;
            if line.number == self.header {
                continue;
            }
            let mut cells = self.cells(&line);
            if cells.iter().all(|cell| cell.is_empty()) {
                self.differences
                    .note_line(Difference::BlankLines, line.number);
                continue;
            }
            while cells.len() > self.columns.len() && cells.last().is_some_and(|it| it.is_empty()) {
                self.differences
                    .note_line(Difference::ExtraCells, line.number);
                cells.pop();
            }
            return Some(Line {
                number: line.number,
                cells,
                is_ended: line.end != End::None,
            });
        }
    }
}

fn separator(header: &str) -> char {
    let of = |separator: &char| header.contains(*separator);
    [',', ';', '\t'].into_iter().find(of).unwrap_or(',')
}

/// The cells of a line without their quotes.
fn split(line: &str, separator: char) -> Vec<Cow<'_, str>> {
    if !line.contains('"') {
        return line.split(separator).map(Cow::Borrowed).collect();
    }
    let (mut cells, mut cell, mut is_quoted) = (Vec::new(), String::new(), false);
    for letter in line.chars() {
        match letter {
            '"' => is_quoted = !is_quoted,
            _ if letter == separator && !is_quoted => {
                cells.push(Cow::Owned(std::mem::take(&mut cell)));
            }
            _ => cell.push(letter),
        }
    }
    cells.push(Cow::Owned(cell));
    cells
}

/// How a line ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    Unix,
    Windows,
    OldMac,
    None,
}

#[derive(Debug, Clone, Copy)]
struct RawLine<'a> {
    number: usize,
    text: &'a str,
    end: End,
}

/// The lines of a text, whichever way they end.
#[derive(Debug, Clone)]
struct Lines<'a> {
    text: &'a str,
    /// Of the line before.
    number: usize,
}

impl<'a> Lines<'a> {
    /// Takes the next line if it is such a one.
    fn next_if(&mut self, is_such: impl Fn(&RawLine<'a>) -> bool) -> Option<RawLine<'a>> {
        let mut after = self.clone();
        let line = after.next().filter(is_such)?;
        *self = after;
        Some(line)
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = RawLine<'a>;

    fn next(&mut self) -> Option<RawLine<'a>> {
        if self.text.is_empty() {
            return None;
        }
        let length = self.text.find(['\n', '\r']).unwrap_or(self.text.len());
        let (text, rest) = self.text.split_at(length);
        let (end, bytes) = match rest.as_bytes() {
            [b'\r', b'\n', ..] => (End::Windows, 2),
            [b'\r', ..] => (End::OldMac, 1),
            [_, ..] => (End::Unix, 1),
            [] => (End::None, 0),
        };
        self.text = &rest[bytes..];
        self.number += 1;
        Some(RawLine {
            number: self.number,
            text,
            end,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
        let mut table = LenientTable::new(text).expect("a header");
        let mut rows = Vec::new();
        while let Some(line) = table.next() {
            let values = line.cells.iter().map(|cell| table.value(cell));
            rows.push(values.map(|value| value.expect("a number")).collect());
        }
        (table.columns, rows)
    }

    #[test]
    fn a_table_from_elsewhere_says_what_it_said() {
        let wanted = values("step,t\n0,0\n1,1e-7\n");
        for other in [
            "\u{feff}step,t\r\n0,0\r\n1,1e-7\r\n",
            "\"step\",\"t\"\n\"0\",\"0\"\n\"1\",\"1E-07\"\n",
            "step;t\n0;0\n1;0,0000001\n",
            "step\tt\n0\t0\n1\t1.00E-07",
            "step,t,,\n\n0,0,,\n , \n1, 1e-7 ,,\n,,,\n\n",
            "step,t\r0,0\r1,1e-7\r",
            "0,0\n1,1e-7\nstep,t\n",
            "sep=,\n\nstep,t\n0,0\n1,1e-7",
            "sep=;\n0;0\nstep;t\n1;1e-7",
        ] {
            assert_eq!(values(other), wanted, "{other:?}");
        }
        assert!(LenientTable::new("").is_none() && LenientTable::new("\r\n").is_none());
        assert!(LenientTable::new("\u{feff}").is_none());
    }

    #[test]
    fn what_differs_is_told_with_its_lines() {
        let differences = |text: &str| {
            let mut table = LenientTable::new(text).expect("a header");
            while let Some(line) = table.next() {
                for cell in &line.cells {
                    table.canonical(cell, line.number).expect("a number");
                }
            }
            table.differences().words()
        };
        assert_eq!(differences("step,t\n0,0\n1,1e-7\n2,"), "");
        for (text, words) in [
            (
                "step,t\n0,0,\n1,1,,\n",
                "empty cells at the ends of lines (2 lines, the first is 2)",
            ),
            ("step,t\n0,0\n,,,\n", "blank lines (line 3)"),
            ("step,t\n0, 0\n", "blanks around cells (line 2)"),
            (
                "step,t\n0,0\n1,0.50\n",
                "numbers written in another way (line 3)",
            ),
            ("0,0\nstep,t\n", "its header among the rows (line 2)"),
            (
                "step,t\r0,0\r",
                "CR at the ends of lines (2 lines, the first is 1)",
            ),
            ("step,t\n0,\"0\"\n", "quoted cells (line 2)"),
        ] {
            assert_eq!(differences(text), words, "{text:?}");
        }
    }
}
