//! The types that a parameter of a scene may have: how a value is read from TOML and checked, and how it is
//! written.

use std::fmt;
use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use super::error::SceneError;
use super::nodal_file::{Context, NodalKey, NodalValues};
use super::reader::{Bound, Field};
use super::write::{number, quoted, vector};

/// A parameter of a table, as it is declared.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameter {
    /// Its key in the table.
    pub key: &'static str,
    /// What it is.
    pub words: &'static str,
    /// What it is where the scene does not say.
    pub default: DefaultValue,
    /// What is allowed.
    pub allowed: String,
    /// By which its values may come from a file.
    pub nodal_key: Option<NodalKey>,
    /// The kinds of the table that have it; none: all of them.
    pub kinds: &'static [&'static str],
    /// Whether it can change while a run goes.
    pub is_tunable: bool,
}

/// What a parameter is where the scene does not say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DefaultValue {
    /// This value, as TOML.
    Value(String),
    /// There is none.
    Absent,
    /// A scene with the table must say.
    Required,
}

impl DefaultValue {
    /// A value, where it is written at all.
    pub(super) fn of<T: Value>(value: &T) -> Self {
        value.write().map_or(Self::Absent, Self::Value)
    }
}

/// Lists the parameters of a table that is read by hand, since its keys depend on its kind:
/// `key of kinds, default, allowed, words;`, with the key of its nodal values at the end if it has any.
macro_rules! parameters {
    ($($key:ident of $kinds:expr, $default:expr, $allowed:expr, $words:literal $(, $nodal:expr)?;)+) => {
        vec![$($crate::scene::parameter::Parameter {
            key: stringify!($key),
            words: $words,
            default: $default,
            allowed: $allowed.into(),
            nodal_key: [$($nodal)?].into_iter().next(),
            kinds: $kinds,
            is_tunable: false,
        }),+]
    };
}
pub(super) use parameters;

/// Declares a choice between words: an enum whose values say their word.
macro_rules! choice {
    (
        $(#[doc = $about:literal])+
        $visibility:vis enum $Choice:ident {
            $($(#[doc = $words:literal])+ $Value:ident = $word:literal,)+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        $visibility enum $Choice {
            $($(#[doc = $words])+ $Value,)+
        }

        impl $crate::scene::parameter::Choice for $Choice {
            const NAMES: &'static [(&'static str, Self)] = &[$(($word, Self::$Value)),+];
        }
    };
}
pub(super) use choice;

/// A type that a parameter may have.
pub(super) trait Value: Sized {
    /// What its values must be, where that is not the same for every parameter of the type.
    type Bound: 'static;

    /// Reads and checks a value.
    fn read(
        field: &Field<'_>,
        bound: &Self::Bound,
        context: &mut Context<'_>,
    ) -> Result<Self, SceneError>;

    /// As TOML; `None`: its key is left out.
    fn write(&self) -> Option<String>;

    /// What is allowed, in words.
    fn words(bound: &Self::Bound) -> String;

    /// By which the values may come from a file.
    fn nodal_key(_bound: &Self::Bound) -> Option<NodalKey> {
        None
    }

    /// The values, where they are from a file.
    fn nodal_values(&mut self) -> Option<&mut NodalValues> {
        None
    }

    /// It, as a change in the course of a run has it; `None`: there are no changes to such a value.
    fn to_parameter(&self) -> Option<ParameterValue> {
        None
    }

    /// Takes the value of a change; returns whether that is of its type.
    fn set_parameter(&mut self, _value: &ParameterValue) -> bool {
        false
    }
}

/// The value of a parameter that can change while a run goes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ParameterValue {
    /// A number.
    Number(f64),
    /// A word, or a formula.
    Text(String),
    /// On or off.
    Switch(bool),
}

impl ParameterValue {
    /// It, if it is a number.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Text(_) | Self::Switch(_) => None,
        }
    }
}

/// As TOML.
impl fmt::Display for ParameterValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(value) => f.write_str(&number(*value)),
            Self::Text(text) => f.write_str(&quoted(text)),
            Self::Switch(is_on) => is_on.fmt(f),
        }
    }
}

/// Says of a plain type how it is read by a bound, written, and what the bound allows.
macro_rules! plain {
    ($Type:ty, $Bound:ty, $read:expr, $write:expr, $words:expr $(, $($more:tt)+)?) => {
        impl $crate::scene::parameter::Value for $Type {
            type Bound = $Bound;

            fn read(
                field: &$crate::scene::reader::Field<'_>,
                bound: &$Bound,
                _: &mut $crate::scene::nodal_file::Context<'_>,
            ) -> Result<Self, $crate::scene::error::SceneError> {
                $read(field, bound)
            }

            fn write(&self) -> Option<String> {
                $write(self)
            }

            fn words(bound: &$Bound) -> String {
                $words(bound)
            }

            $($($more)+)?
        }
    };
}

plain! {
    f64, Bound,
    |field: &Field<'_>, bound: &Bound| field.number(*bound),
    |value: &f64| Some(number(*value)),
    |bound: &Bound| bound.words.to_owned(),
    fn to_parameter(&self) -> Option<ParameterValue> {
        Some(ParameterValue::Number(*self))
    }

    fn set_parameter(&mut self, value: &ParameterValue) -> bool {
        value.number().map(|number| *self = number).is_some()
    }
}
plain! {
    bool, (),
    |field: &Field<'_>, (): &()| field.switch(),
    |value: &bool| Some(value.to_string()),
    |(): &()| "true or false".to_owned(),
    fn to_parameter(&self) -> Option<ParameterValue> {
        Some(ParameterValue::Switch(*self))
    }

    fn set_parameter(&mut self, value: &ParameterValue) -> bool {
        let ParameterValue::Switch(is_on) = value else {
            return false;
        };
        *self = *is_on;
        true
    }
}
plain! {
    Option<f64>, Bound,
    |field: &Field<'_>, bound: &Bound| field.number(*bound).map(Some),
    |value: &Option<f64>| value.map(number),
    f64::words
}
plain! {
    [f64; 2], Bound,
    |field: &Field<'_>, bound: &Bound| field.vector(*bound),
    |value: &[f64; 2]| Some(vector(*value)),
    |_: &Bound| "an array of two numbers, such as [0.5, 0.5]".to_owned()
}
plain! {
    u64, RangeInclusive<u64>,
    Field::integer,
    |value: &u64| Some(value.to_string()),
    |bound: &RangeInclusive<u64>| format!("a whole number from {} to {}", bound.start(), bound.end())
}

/// What is allowed for the name of a file, in words.
pub(super) const PATH: &str = "a path, relative to the scene's file";

/// The bound of a seed: any number that a generator takes.
pub(super) const SEEDS: RangeInclusive<u64> = 0..=u64::MAX;
/// The seed of every generator, unless the scene says.
pub(super) const SEED: u64 = 1;

/// One of several words.
pub(super) trait Choice: Copy + PartialEq + 'static {
    /// The words, each with what it means; every value is among them.
    const NAMES: &'static [(&'static str, Self)];

    /// The word for it in a scene.
    fn word(self) -> &'static str {
        let name = Self::NAMES.iter().find(|(_, meant)| *meant == self);
        name.map_or("", |(name, _)| name)
    }
}

impl<T: Choice> Value for T {
    type Bound = ();

    fn read(field: &Field<'_>, (): &(), _: &mut Context<'_>) -> Result<Self, SceneError> {
        field.choice(Self::NAMES)
    }

    fn write(&self) -> Option<String> {
        Some(quoted(self.word()))
    }

    fn words((): &()) -> String {
        one_of(Self::NAMES)
    }

    fn to_parameter(&self) -> Option<ParameterValue> {
        Some(ParameterValue::Text(self.word().to_owned()))
    }

    fn set_parameter(&mut self, value: &ParameterValue) -> bool {
        let ParameterValue::Text(word) = value else {
            return false;
        };
        let named = Self::NAMES.iter().find(|(name, _)| name == word);
        named.map(|(_, meant)| *self = *meant).is_some()
    }
}

/// The words of a choice, for messages.
pub(super) fn one_of<T>(names: &[(&'static str, T)]) -> String {
    let names: Vec<String> = names
        .iter()
        .map(|(name, _)| format!("\"{name}\""))
        .collect();
    format!("one of {}", names.join(", "))
}
