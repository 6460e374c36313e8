//! Values as TOML.

/// A table in a line.
pub(super) fn inline(keys: &[(&'static str, String)]) -> String {
    let keys: Vec<String> = keys
        .iter()
        .map(|(key, value)| format!("{key} = {value}"))
        .collect();
    format!("{{ {} }}", keys.join(", "))
}

pub(super) fn vector([x, y]: [f64; 2]) -> String {
    format!("[{}, {}]", number(x), number(y))
}

pub(super) fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// The fewest digits that read back as the same number; small ones as people write them, 1e-3.
pub(super) fn number(value: f64) -> String {
    let (plain, scientific) = (format!("{value:?}"), format!("{value:e}"));
    if value.abs() < 0.1 && value != 0.0 && scientific.len() < plain.len() {
        scientific
    } else {
        plain
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_look_as_people_write_them() {
        let written = |values: &[f64]| values.iter().map(|v| number(*v)).collect::<Vec<_>>();
        assert_eq!(
            written(&[
                1e-7, 1e-3, 0.01, 0.075, 10.1, 0.0, 90.0, -0.5, 1e-5, 2.5e-7, 120.0
            ]),
            [
                "1e-7", "1e-3", "0.01", "0.075", "10.1", "0.0", "90.0", "-0.5", "1e-5", "2.5e-7",
                "120.0"
            ],
        );
    }

    proptest! {
        #[test]
        fn numbers_read_back_exactly(value in proptest::num::f64::NORMAL) {
            let text = format!("v = {}", number(value));
            let table: toml::Table = text.parse().expect("TOML");
            prop_assert_eq!(table["v"].as_float(), Some(value));
        }

        #[test]
        fn strings_read_back_exactly(value in any::<String>()) {
            let text = format!("v = {}", quoted(&value));
            let table: toml::Table = text.parse().expect("TOML");
            prop_assert_eq!(table["v"].as_str(), Some(&value[..]));
        }
    }
}
