//! Which values of a scene are so large or so small that squares and products of them leave the range of numbers.

use crate::scene::Scene;

/// Values beyond this, or below one over it, are extreme.
const EXTREME: f64 = 1e30;

/// The extreme values of a scene as `key = value`, those that are furthest from 1 first.
pub(super) fn extreme_values(scene: &Scene) -> Vec<String> {
    let mut found = Vec::new();
    if let Ok(table) = scene.to_toml().parse::<toml::Table>() {
        collect("", &toml::Value::Table(table), &mut found);
    }
    found.sort_by(|(_, one), (_, other)| distance(*other).total_cmp(&distance(*one)));
    let words = found
        .into_iter()
        .map(|(key, value)| format!("{key} = {value:?}"));
    words.collect()
}

/// How far a value is from 1, in powers of ten.
fn distance(value: f64) -> f64 {
    value.abs().log10().abs()
}

fn collect(key: &str, value: &toml::Value, found: &mut Vec<(String, f64)>) {
    match value {
        toml::Value::Table(table) => {
            for (name, value) in table {
                let key = match key {
                    "" => name.clone(),
                    key => format!("{key}.{name}"),
                };
                collect(&key, value, found);
            }
        }
        toml::Value::Array(values) => {
            for (number, value) in values.iter().enumerate() {
                collect(&format!("{key}[{number}]"), value, found);
            }
        }
        toml::Value::Float(value) if *value != 0.0 && distance(*value) >= EXTREME.log10() => {
            found.push((key.to_owned(), *value));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_far_from_1_are_found_the_furthest_first() {
        let scene = Scene::of_text(
            "area = { target = 1.1, penalty = 1e-310 }\nmembrane.mobility = 1e200",
            &[],
        );
        let expected = ["area.penalty = 1e-310", "membrane.mobility = 1e200"];
        assert_eq!(extreme_values(&scene), expected);
        assert!(extreme_values(&Scene::default()).is_empty());
    }
}
