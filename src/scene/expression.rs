//! Formulas in x and y.
//!
//! The usual rules hold: `-x^2` is −(x²), `2^3^2` is 2⁹, `a - b - c` is (a − b) − c. The grammar:
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = signed (("*" | "/") signed)*
//! signed  = ("+" | "-") signed | power
//! power   = atom ("^" signed)?
//! atom    = number | name | name "(" sum ("," sum)* ")" | "(" sum ")"
//! ```
//!
//! A formula becomes a list of instructions for a stack machine while it is read, so that only the
//! reading recurses, and no deeper than a fixed bound.

use std::ops::Range;
use std::sync::Arc;

use thiserror::Error;

use crate::geometry::Point;

use super::error::{Quoted, did_you_mean};
use super::suggest::nearest;

/// Signs, powers and parentheses inside each other; each level is a recursion of the parser.
const DEEPEST_NESTING: usize = 64;
/// Bytes of a formula; each node of the mesh evaluates it.
const LONGEST_TEXT: usize = 4096;

const CONSTANTS: [(&str, Instruction); 4] = [
    ("x", Instruction::X),
    ("y", Instruction::Y),
    ("pi", Instruction::Constant(std::f64::consts::PI)),
    ("e", Instruction::Constant(std::f64::consts::E)),
];

const FUNCTIONS: [(&str, Instruction); 23] = [
    ("sqrt", Instruction::Unary(f64::sqrt)),
    ("exp", Instruction::Unary(f64::exp)),
    ("ln", Instruction::Unary(f64::ln)),
    ("log2", Instruction::Unary(f64::log2)),
    ("log10", Instruction::Unary(f64::log10)),
    ("sin", Instruction::Unary(f64::sin)),
    ("cos", Instruction::Unary(f64::cos)),
    ("tan", Instruction::Unary(f64::tan)),
    ("asin", Instruction::Unary(f64::asin)),
    ("acos", Instruction::Unary(f64::acos)),
    ("atan", Instruction::Unary(f64::atan)),
    ("sinh", Instruction::Unary(f64::sinh)),
    ("cosh", Instruction::Unary(f64::cosh)),
    ("tanh", Instruction::Unary(f64::tanh)),
    ("abs", Instruction::Unary(f64::abs)),
    ("sign", Instruction::Unary(sign)),
    ("floor", Instruction::Unary(f64::floor)),
    ("ceil", Instruction::Unary(f64::ceil)),
    ("round", Instruction::Unary(f64::round)),
    ("min", Instruction::Binary(f64::min)),
    ("max", Instruction::Binary(f64::max)),
    ("hypot", Instruction::Binary(f64::hypot)),
    ("atan2", Instruction::Binary(f64::atan2)),
];

/// Functions by the names that they have elsewhere, and what to write for them here.
const FUNCTIONS_ELSEWHERE: [(&str, &str); 7] = [
    ("log", "ln, log10 or log2"),
    ("lg", "log10"),
    ("ld", "log2"),
    ("tg", "tan"),
    ("sgn", "sign"),
    ("pow", "a^b"),
    ("power", "a^b"),
];

/// Variables that others have, and what to write for them here.
const VARIABLES_ELSEWHERE: [(&str, &str); 3] = [
    ("r", "sqrt(x^2 + y^2), the distance from (0, 0)"),
    ("rho", "sqrt(x^2 + y^2), the distance from (0, 0)"),
    ("theta", "atan2(y, x), the polar angle"),
];

/// What was probably meant by a name that does not exist: one of those that may stand there, or what to write
/// in its place.
fn meant(name: &str, called: bool, allowed: &[&'static str]) -> Option<String> {
    let elsewhere = match called {
        true => &FUNCTIONS_ELSEWHERE[..],
        false => &VARIABLES_ELSEWHERE[..],
    };
    let lower = name.to_lowercase();
    if let Some((_, here)) = elsewhere.iter().find(|(known, _)| *known == lower) {
        return Some((*here).to_owned());
    }
    match nearest(name, allowed.iter().copied()) {
        Some(near) => Some(format!("'{near}'")),
        None if called => None,
        None => uncalled(name),
    }
}

/// A function without its parentheses: `log`, `sinx`.
fn uncalled(name: &str) -> Option<String> {
    let argument = |rest: &str| CONSTANTS.iter().any(|(known, _)| *known == rest);
    let known = FUNCTIONS.iter().map(|(known, _)| (*known, *known));
    let elsewhere = FUNCTIONS_ELSEWHERE.into_iter();
    let elsewhere = elsewhere.filter(|(_, here)| !here.contains('^'));
    known.chain(elsewhere).find_map(|(known, here)| {
        let rest = name.strip_prefix(known)?;
        match rest {
            "" => Some(format!("{here}, with its argument in parentheses")),
            rest if argument(rest) => Some(format!(
                "{here}, with the argument in parentheses: ({rest})"
            )),
            _ => None,
        }
    })
}

/// −1, 0 or 1 (the standard library's has no 0).
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// A formula in x and y, such as `exp(-(x-0.5)^2 / 1e-2)`.
#[derive(Debug, Clone)]
pub struct Expression {
    text: String,
    instructions: Arc<[Instruction]>,
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

/// One step of the stack machine.
#[derive(Debug, Clone, Copy)]
enum Instruction {
    Constant(f64),
    X,
    Y,
    Unary(fn(f64) -> f64),
    Binary(fn(f64, f64) -> f64),
}

/// What is wrong with a formula, and where in it.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{problem}")]
pub struct ExpressionError {
    /// Bytes of the formula.
    pub range: Range<usize>,
    /// What is wrong there.
    pub problem: ExpressionProblem,
}

/// What is wrong with a formula.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ExpressionProblem {
    /// It ends too early.
    #[error("the expression ends where {expected} should follow")]
    Incomplete {
        /// What is missing.
        expected: &'static str,
    },
    /// Something stands in the wrong place.
    #[error("the expression has {} where {expected} should stand", Quoted(found))]
    Unexpected {
        /// The character or the word.
        found: String,
        /// What could stand there.
        expected: &'static str,
    },
    /// Neither a variable nor a constant nor a function.
    #[error("unknown name {} in the expression{} Allowed: {}", Quoted(name), did_you_mean(meant.as_ref()),
        allowed.join(", "))]
    UnknownName {
        /// The name.
        name: String,
        /// What was probably meant.
        meant: Option<String>,
        /// What may stand there.
        allowed: Vec<&'static str>,
    },
    /// A function of another number of arguments.
    #[error("the function '{function}' takes {expected} argument(s), not {found}")]
    Arguments {
        /// The function.
        function: &'static str,
        /// How many it takes.
        expected: usize,
        /// How many are given.
        found: usize,
    },
    /// Too many parentheses, signs or powers inside each other.
    #[error("the expression nests more than {DEEPEST_NESTING} levels deep")]
    TooDeep,
    /// More text than a formula needs.
    #[error("the expression is longer than {LONGEST_TEXT} bytes; give nodal values in a file")]
    TooLong,
    /// A value that is not finite.
    #[error(
        "the expression is {value} at (x, y) = ({x}, {y}); it must be finite in all of the domain"
    )]
    NotFinite {
        /// The value.
        value: f64,
        /// Where.
        x: f64,
        /// Where.
        y: f64,
    },
}

impl std::str::FromStr for Expression {
    type Err = ExpressionError;

    fn from_str(text: &str) -> Result<Self, ExpressionError> {
        if text.len() > LONGEST_TEXT {
            let range = 0..text.len();
            return Err(ExpressionError {
                range,
                problem: ExpressionProblem::TooLong,
            });
        }
        let mut parser = Parser {
            text,
            at: 0,
            depth: 0,
            instructions: Vec::new(),
        };
        parser.sum()?;
        match parser.peek() {
            None => Ok(Self {
                text: text.to_owned(),
                instructions: parser.instructions.into(),
            }),
            Some(_) => Err(parser.unexpected("an operator or the end")),
        }
    }
}

impl Expression {
    /// The formula as the user wrote it.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Its value at (x, y).
    pub fn evaluate(&self, x: f64, y: f64) -> f64 {
        let mut stack = Vec::with_capacity(8);
        for instruction in self.instructions.iter() {
            let value = match *instruction {
                Instruction::Constant(value) => value,
                Instruction::X => x,
                Instruction::Y => y,
                Instruction::Unary(function) => function(pop(&mut stack)),
                Instruction::Binary(function) => {
                    let right = pop(&mut stack);
                    function(pop(&mut stack), right)
                }
            };
            stack.push(value);
        }
        pop(&mut stack)
    }

    /// Checks that the formula is finite at the nodes of a grid of `cells` × `cells` squares.
    pub(super) fn check_finite(&self, cells: usize) -> Result<(), ExpressionError> {
        let coordinate = |index: usize| index as f64 / cells as f64;
        let nodes = (0..=cells).flat_map(|j| (0..=cells).map(move |i| (j, i)));
        self.try_at(nodes.map(|(j, i)| Point::new(coordinate(i), coordinate(j))))
    }

    /// Checks that the formula is finite at these places.
    pub(super) fn check_finite_at(&self, places: &[Point]) -> Result<(), ExpressionError> {
        self.try_at(places.iter().copied())
    }

    fn try_at(&self, places: impl Iterator<Item = Point>) -> Result<(), ExpressionError> {
        for place in places {
            let [x, y] = place.into();
            let value = self.evaluate(x, y);
            if !value.is_finite() {
                let problem = ExpressionProblem::NotFinite { value, x, y };
                return Err(ExpressionError {
                    range: 0..self.text.len(),
                    problem,
                });
            }
        }
        Ok(())
    }
}

/// The parser emits no instruction before its operands, so the stack is never empty here; if it
/// were, the value would be seen as not finite.
fn pop(stack: &mut Vec<f64>) -> f64 {
    stack.pop().unwrap_or(f64::NAN)
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    instructions: Vec<Instruction>,
}

impl<'a> Parser<'a> {
    fn sum(&mut self) -> Result<(), ExpressionError> {
        self.product()?;
        loop {
            let operation = match self.peek() {
                Some('+') => |a, b| a + b,
                Some('-') => |a: f64, b: f64| a - b,
                _ => return Ok(()),
            };
            self.at += 1;
            self.product()?;
            self.instructions.push(Instruction::Binary(operation));
        }
    }

    fn product(&mut self) -> Result<(), ExpressionError> {
        self.signed()?;
        loop {
            let operation = match self.peek() {
                Some('*') => |a, b| a * b,
                Some('/') => |a: f64, b: f64| a / b,
                _ => return Ok(()),
            };
            self.at += 1;
            self.signed()?;
            self.instructions.push(Instruction::Binary(operation));
        }
    }

    /// Every recursion of the grammar passes here.
    fn signed(&mut self) -> Result<(), ExpressionError> {
        if self.depth == DEEPEST_NESTING {
            let range = self.at..self.text.len();
            return Err(ExpressionError {
                range,
                problem: ExpressionProblem::TooDeep,
            });
        }
        self.depth += 1;
        match self.peek() {
            Some('+') => {
                self.at += 1;
                self.signed()?;
            }
            Some('-') => {
                self.at += 1;
                self.signed()?;
                self.instructions.push(Instruction::Unary(|value| -value));
            }
            _ => self.power()?,
        }
        self.depth -= 1;
        Ok(())
    }

    fn power(&mut self) -> Result<(), ExpressionError> {
        self.atom()?;
        if self.take('^') {
            self.signed()?;
            self.instructions.push(Instruction::Binary(f64::powf));
        }
        Ok(())
    }

    fn atom(&mut self) -> Result<(), ExpressionError> {
        match self.peek() {
            Some('(') => {
                self.at += 1;
                self.sum()?;
                self.close()
            }
            Some(first) if first.is_ascii_digit() || first == '.' => self.number(),
            Some(first) if first.is_alphabetic() || first == '_' => self.name(),
            _ => Err(self.unexpected("a number, x, y, a function or '('")),
        }
    }

    fn number(&mut self) -> Result<(), ExpressionError> {
        let rest = &self.text[self.at..];
        let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
        let mut length = digits(rest);
        if rest[length..].starts_with('.') {
            length += 1 + digits(&rest[length + 1..]);
        }
        if rest[length..].starts_with(['e', 'E']) {
            let signed = rest[length + 1..].starts_with(['+', '-']);
            let mantissa = length + 1 + usize::from(signed);
            let exponent = digits(&rest[mantissa..]);
            // Without digits the e is no exponent; the error is then about the e.
            length = if exponent > 0 {
                mantissa + exponent
            } else {
                length
            };
        }
        let Ok(value) = rest[..length].parse() else {
            return Err(self.unexpected("a number, x, y, a function or '('"));
        };
        self.at += length;
        self.instructions.push(Instruction::Constant(value));
        Ok(())
    }

    fn name(&mut self) -> Result<(), ExpressionError> {
        let start = self.at;
        let name = self.word();
        self.at += name.len();
        let range = start..self.at;
        let called = self.take('(');
        let names: &[(&'static str, Instruction)] = if called { &FUNCTIONS } else { &CONSTANTS };
        let Some(&(name, instruction)) = names.iter().find(|(known, _)| *known == name) else {
            if FUNCTIONS.iter().any(|(known, _)| *known == name) {
                return Err(self.unexpected("'(' and an argument"));
            }
            let allowed: Vec<_> = names.iter().map(|(known, _)| *known).collect();
            let problem = ExpressionProblem::UnknownName {
                meant: meant(name, called, &allowed),
                name: name.to_owned(),
                allowed,
            };
            return Err(ExpressionError { range, problem });
        };
        if called {
            let mut found = 1;
            self.sum()?;
            while self.take(',') {
                self.sum()?;
                found += 1;
            }
            self.close()?;
            let expected = if matches!(instruction, Instruction::Unary(_)) {
                1
            } else {
                2
            };
            if found != expected {
                let problem = ExpressionProblem::Arguments {
                    function: name,
                    expected,
                    found,
                };
                return Err(ExpressionError { range, problem });
            }
        }
        self.instructions.push(instruction);
        Ok(())
    }

    fn close(&mut self) -> Result<(), ExpressionError> {
        if self.take(')') {
            Ok(())
        } else {
            Err(self.unexpected("an operator or ')'"))
        }
    }

    /// The next character after blanks.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        self.at += if found { wanted.len_utf8() } else { 0 };
        found
    }

    /// The letters, digits and underscores that follow.
    fn word(&self) -> &'a str {
        let rest = &self.text[self.at..];
        let end = rest
            .find(|c: char| !c.is_alphanumeric() && c != '_')
            .unwrap_or(rest.len());
        &rest[..end]
    }

    fn unexpected(&mut self, expected: &'static str) -> ExpressionError {
        let Some(next) = self.peek() else {
            let range = self.text.len()..self.text.len();
            return ExpressionError {
                range,
                problem: ExpressionProblem::Incomplete { expected },
            };
        };
        let length = self.word().len().max(next.len_utf8());
        let range = self.at..self.at + length;
        let found = self.text[range.clone()].to_owned();
        ExpressionError {
            range,
            problem: ExpressionProblem::Unexpected { found, expected },
        }
    }
}

#[cfg(test)]
mod tests;
