//! Tables as spreadsheets and editors leave them: with a byte-order mark, CR LF, quoted cells, other
//! separators, blank lines. They are read as what was meant.

use super::Number;
use std::borrow::Cow;
use std::collections::BTreeSet;

/// A table that is read line by line.
#[derive(Debug)]
pub(super) struct LenientTable<'a> {
    /// The names of its columns.
    pub columns: Vec<String>,
    separator: char,
    rest: std::iter::Enumerate<std::str::SplitInclusive<'a, char>>,
    /// In what it differs from a table of vesica, as far as it was read.
    differences: BTreeSet<Difference>,
}

/// A line of it that is not blank.
#[derive(Debug)]
pub(super) struct Line<'a> {
    /// Its number; the header is 1 where nothing stands before it.
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
    Separator,
    Quotes,
    BlankLines,
    NoLastEnd,
    Numbers,
    Order,
    Columns,
}

impl Difference {
    pub fn words(self) -> &'static str {
        match self {
            Self::ByteOrderMark => "a byte-order mark",
            Self::CarriageReturns => "CR LF at the ends of lines",
            Self::Separator => "other separators than commas",
            Self::Quotes => "quoted cells",
            Self::BlankLines => "blank lines",
            Self::NoLastEnd => "no end of the last line",
            Self::Numbers => "numbers written in another way",
            Self::Order => "its rows in another order",
            Self::Columns => "its columns in another order, or further ones",
        }
    }
}

impl<'a> LenientTable<'a> {
    /// Reads the header; `None`: there is none.
    pub fn new(text: &'a str) -> Option<Self> {
        let mut differences = BTreeSet::new();
        let text = match text.strip_prefix('\u{feff}') {
            Some(text) => {
                differences.insert(Difference::ByteOrderMark);
                text
            }
            None => text,
        };
        let mut table = Self {
            columns: Vec::new(),
            separator: ',',
            rest: text.split_inclusive('\n').enumerate(),
            differences,
        };
        let (_, mut header) = table.rest.next()?;
        let of_spreadsheet = header.get(..4);
        if of_spreadsheet.is_some_and(|word| word.eq_ignore_ascii_case("sep=")) {
            table.differences.insert(Difference::Separator);
            (_, header) = table.rest.next()?;
        }
        let of = |separator: &char| header.contains(*separator);
        table.separator = [',', ';', '\t'].into_iter().find(of).unwrap_or(',');
        if table.separator != ',' {
            table.differences.insert(Difference::Separator);
        }
        let mut columns: Vec<String> = table.cells(header).into_iter().map(Cow::into).collect();
        while columns.last().is_some_and(String::is_empty) {
            columns.pop();
        }
        table.columns = columns;
        (!table.columns.is_empty()).then_some(table)
    }

    /// In what it differs from a table of vesica, as far as it was read.
    pub fn differences(&self) -> &BTreeSet<Difference> {
        &self.differences
    }

    /// The text of a cell as vesica would write it; `None`: it is no number.
    pub fn canonical(&mut self, cell: &str) -> Option<String> {
        if cell.is_empty() {
            return Some(String::new());
        }
        let text = Number(self.value(cell)?).to_string();
        if text != cell {
            self.differences.insert(Difference::Numbers);
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

    fn cells(&mut self, line: &'a str) -> Vec<Cow<'a, str>> {
        let line = match line.strip_suffix('\n') {
            Some(line) => line,
            None => {
                self.differences.insert(Difference::NoLastEnd);
                line
            }
        };
        let line = match line.strip_suffix('\r') {
            Some(line) => {
                self.differences.insert(Difference::CarriageReturns);
                line
            }
            None => line,
        };
        if !line.contains('"') {
            return line
                .split(self.separator)
                .map(|cell| Cow::Borrowed(cell.trim()))
                .collect();
        }
        self.differences.insert(Difference::Quotes);
        let (mut cells, mut cell, mut is_quoted) = (Vec::new(), String::new(), false);
        for letter in line.chars() {
            match letter {
                '"' => is_quoted = !is_quoted,
                _ if letter == self.separator && !is_quoted => {
                    cells.push(Cow::Owned(cell.trim().to_owned()));
                    cell.clear();
                }
                _ => cell.push(letter),
            }
        }
        cells.push(Cow::Owned(cell.trim().to_owned()));
        cells
    }
}

impl<'a> Iterator for LenientTable<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        loop {
            let (index, line) = self.rest.next()?;
            let mut cells = self.cells(line);
            if cells.iter().all(|cell| cell.is_empty()) {
                self.differences.insert(Difference::BlankLines);
                continue;
            }
            while cells.len() > self.columns.len() && cells.last().is_some_and(|it| it.is_empty()) {
                cells.pop();
            }
            return Some(Line {
                number: index + 1,
                cells,
                is_ended: line.ends_with('\n'),
            });
        }
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
        ] {
            assert_eq!(values(other), wanted, "{other:?}");
        }
        assert!(LenientTable::new("").is_none() && LenientTable::new("\r\n").is_none());
        assert!(LenientTable::new("\u{feff}").is_none());
    }
}
