//! The dialog in which parameters are changed while the run goes.

use crate::scene::{Assignment, ParameterValue, Scene, tables};

/// The parameters that can change, their values, and what is typed.
#[derive(Debug, Clone, PartialEq)]
pub struct Knobs {
    /// The parameters that the scene has.
    pub lines: Vec<Knob>,
    /// The chosen one.
    pub chosen: usize,
    /// A number that is being typed.
    pub typed: Option<String>,
    /// Whether it is the duration.
    pub types_duration: bool,
    /// How long the change takes, on the clock of the run.
    pub over: f64,
    /// Why the change cannot be made.
    pub error: Option<String>,
}

/// A parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Knob {
    /// With its table, such as `area.target`.
    pub key: String,
    /// What it is.
    pub words: &'static str,
    /// What is allowed.
    pub allowed: String,
    /// Its present value.
    pub before: ParameterValue,
    /// The value that it is to have.
    pub value: ParameterValue,
}

impl Knob {
    /// Whether it is to have another value.
    pub fn is_turned(&self) -> bool {
        self.value != self.before
    }

    /// The next or the previous value: a part smaller or larger, another word, on or off. A formula stays.
    fn turn(&mut self, by: i32, part: f64) {
        let next = match &self.value {
            // From 0 a number is turned by the part itself.
            ParameterValue::Number(value) if *value == 0.0 => {
                Some(ParameterValue::Number(f64::from(by) * part))
            }
            ParameterValue::Number(value) => {
                let change = f64::from(by) * part * value.abs();
                Some(ParameterValue::Number(rounded(value + change)))
            }
            ParameterValue::Switch(is_on) => Some(ParameterValue::Switch(!is_on)),
            ParameterValue::Text(word) => next_word(&self.allowed, word, by),
        };
        self.value = next.unwrap_or_else(|| self.value.clone());
    }
}

/// The word before or after one of those that are allowed, which stand in quotes.
fn next_word(allowed: &str, word: &str, by: i32) -> Option<ParameterValue> {
    let words: Vec<&str> = allowed.split('"').skip(1).step_by(2).collect();
    let place = words.iter().position(|other| *other == word)? as i32;
    let next = (place + by).rem_euclid(words.len() as i32);
    Some(ParameterValue::Text(words[next as usize].to_owned()))
}

/// A number with six digits: what is turned is to look as it was typed.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

impl Knobs {
    /// Those of a scene, with the values that they have at a time.
    pub fn of(scene: &Scene, t: f64) -> Self {
        let parameters = tables().into_iter().flat_map(|table| {
            let tunable = table.parameters.into_iter().filter(|it| it.is_tunable);
            tunable.map(move |parameter| (table.name, parameter))
        });
        let lines = parameters.filter_map(|(table, parameter)| {
            let key = format!("{table}.{}", parameter.key);
            let before = scene.parameter_at(t, &key)?;
            Some(Knob {
                key,
                words: parameter.words,
                allowed: parameter.allowed,
                value: before.clone(),
                before,
            })
        });
        Self {
            lines: lines.collect(),
            chosen: 0,
            typed: None,
            types_duration: false,
            over: 0.0,
            error: None,
        }
    }

    /// Chooses another line.
    pub fn choose(&mut self, by: i32) {
        let count = self.lines.len() as i32;
        self.chosen = (self.chosen as i32 + by).rem_euclid(count.max(1)) as usize;
        self.typed = None;
        self.types_duration = false;
    }

    /// Turns the chosen one, by 5 % or by 1 %.
    pub fn turn(&mut self, by: i32, is_fine: bool) {
        self.typed = None;
        if let Some(knob) = self.lines.get_mut(self.chosen) {
            knob.turn(by, if is_fine { 0.01 } else { 0.05 });
        }
    }

    /// Takes a character of a number.
    pub fn type_in(&mut self, character: char) {
        let is_number = self.types_duration
            || (self.lines.get(self.chosen)).is_some_and(|knob| knob.value.number().is_some());
        if is_number && (character.is_ascii_digit() || "+-.eE".contains(character)) {
            self.typed.get_or_insert_default().push(character);
        }
    }

    /// Takes the number that was typed; whether there was one.
    ///
    /// # Errors
    /// It is no number, in words.
    pub fn take_typed(&mut self) -> Result<bool, String> {
        let Some(typed) = self.typed.take() else {
            return Ok(false);
        };
        let number = typed.parse::<f64>().ok().filter(|it| it.is_finite());
        let number = number.ok_or_else(|| format!("'{typed}' is no number"))?;
        if self.types_duration {
            if number < 0.0 {
                return Err("a duration is at least 0".to_owned());
            }
            self.over = number;
            self.types_duration = false;
        } else if let Some(knob) = self.lines.get_mut(self.chosen) {
            knob.value = ParameterValue::Number(number);
        }
        Ok(true)
    }

    /// What is to be changed.
    pub fn assignments(&self) -> Vec<Assignment> {
        let turned = self.lines.iter().filter(|knob| knob.is_turned());
        let assignment = |knob: &Knob| Assignment {
            key: knob.key.clone(),
            value: knob.value.clone(),
        };
        turned.map(assignment).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knobs() -> Knobs {
        let text =
            "area.target = 1.2\nnematic.weight = 3\n[anchoring]\n[field]\n[pull]\npotential = 'x'";
        Knobs::of(&Scene::of_text(text, &[]), 0.0)
    }

    fn choose(knobs: &mut Knobs, key: &str) {
        knobs.chosen = knobs
            .lines
            .iter()
            .position(|knob| knob.key == key)
            .expect(key);
    }

    fn set(knobs: &Knobs) -> Vec<String> {
        let set = knobs.assignments().into_iter();
        set.map(|it| format!("{} = {}", it.key, it.value)).collect()
    }

    #[test]
    fn they_are_those_of_the_scene_s_tables() {
        let scene = Scene::of_text("[area]", &[]);
        let keys: Vec<String> = Knobs::of(&scene, 0.0)
            .lines
            .into_iter()
            .map(|it| it.key)
            .collect();
        let wanted = [
            "membrane.mobility",
            "membrane.spontaneous_curvature",
            "area.target",
            "area.penalty",
        ];
        assert_eq!(keys, wanted);
        assert!(knobs().assignments().is_empty());
    }

    #[test]
    fn numbers_words_and_switches_are_turned() {
        let mut knobs = knobs();
        choose(&mut knobs, "area.target");
        knobs.turn(1, false);
        knobs.turn(-1, true);
        choose(&mut knobs, "membrane.spontaneous_curvature");
        knobs.turn(-1, false);
        choose(&mut knobs, "anchoring.kind");
        knobs.turn(1, false);
        choose(&mut knobs, "field.on");
        knobs.turn(1, false);
        choose(&mut knobs, "pull.potential");
        knobs.turn(1, false);
        let wanted = [
            "membrane.spontaneous_curvature = -0.05",
            "area.target = 1.2474",
            "anchoring.kind = \"parallel\"",
            "field.on = false",
        ];
        assert_eq!(set(&knobs), wanted);
        choose(&mut knobs, "anchoring.kind");
        knobs.turn(-1, false);
        assert_eq!(set(&knobs).len(), 3);
    }

    #[test]
    fn numbers_are_typed() {
        let mut knobs = knobs();
        choose(&mut knobs, "area.target");
        "1x.1r".chars().for_each(|letter| knobs.type_in(letter));
        assert_eq!(knobs.typed.as_deref(), Some("1.1"));
        assert_eq!(knobs.take_typed(), Ok(true));
        assert_eq!(set(&knobs), ["area.target = 1.1"]);
        assert_eq!(knobs.take_typed(), Ok(false));
        "1e".chars().for_each(|letter| knobs.type_in(letter));
        assert_eq!(knobs.take_typed(), Err("'1e' is no number".to_owned()));
        knobs.types_duration = true;
        "2e-4".chars().for_each(|letter| knobs.type_in(letter));
        assert_eq!((knobs.take_typed(), knobs.over), (Ok(true), 2e-4));
        choose(&mut knobs, "anchoring.kind");
        knobs.type_in('1');
        assert_eq!(knobs.typed, None);
    }
}
