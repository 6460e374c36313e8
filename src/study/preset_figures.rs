//! How accurate the presets of the paper's four cases are, and how long they take: measured once, for what is said
//! before a run.

use crate::scene::AnchoringKind;

/// What was measured of a preset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PresetFigures {
    /// ‖φ − φ*‖ in L2 at the end, against a finer run.
    pub error: f64,
    /// Of one core, in seconds.
    pub seconds: f64,
}

/// Error of φ and seconds of each preset with homeotropic anchoring: a virtual EPYC, 2026-11-27; the command is in
/// docs/guide/accuracy.md, and its table has the same figures.
const MEASURED: [(&str, f64, f64); 8] = [
    ("case1-quick", 9.1e-3, 0.8),
    ("case2-quick", 6.6e-3, 0.9),
    ("case3-quick", 7.8e-3, 0.8),
    ("case4-quick", 9.5e-3, 0.7),
    ("case1", 1.6e-2, 210.0),
    ("case2", 1.2e-2, 210.0),
    ("case3", 1.1e-2, 210.0),
    ("case4", 2.3e-2, 210.0),
];

/// The case that has the same φ with the other anchoring: its director is turned by 90° (in two
/// dimensions homeotropic anchoring of d is parallel anchoring of d turned by 90°).
const TURNED: [(&str, &str); 4] = [
    ("case1", "case2"),
    ("case2", "case1"),
    ("case3", "case4"),
    ("case4", "case3"),
];

impl PresetFigures {
    /// Those of a preset with an anchoring; `None` where they were not measured.
    pub fn of(preset: &str, anchoring: AnchoringKind) -> Option<Self> {
        let turned = |preset: &str| {
            let (case, form) = preset.split_at_checked(5)?;
            let (_, other) = TURNED.iter().find(|(known, _)| *known == case)?;
            Some(format!("{other}{form}"))
        };
        let measured = match anchoring {
            AnchoringKind::Homeotropic => preset.to_owned(),
            AnchoringKind::Parallel => turned(preset)?,
            AnchoringKind::None => return None,
        };
        let (_, error, seconds) = MEASURED.into_iter().find(|(name, ..)| *name == measured)?;
        Some(Self { error, seconds })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_other_anchoring_is_the_turned_case() {
        let of = PresetFigures::of;
        assert_eq!(
            of("case3-quick", AnchoringKind::Parallel),
            of("case4-quick", AnchoringKind::Homeotropic)
        );
        assert_eq!(of("case3-quick", AnchoringKind::None), None);
        assert_eq!(of("case3-fine", AnchoringKind::Homeotropic), None);
        assert_eq!(of("é", AnchoringKind::Parallel), None);
    }

    #[test]
    fn the_guide_has_the_same_figures() {
        let guide = include_str!("../../docs/guide/accuracy.md");
        for (name, error, seconds) in MEASURED {
            let row = guide
                .lines()
                .find(|line| line.starts_with(&format!("| `{name}` |")))
                .expect(name);
            let cells: Vec<&str> = row.split('|').map(str::trim).collect();
            assert_eq!(cells[3].parse(), Ok(error), "{row}");
            let time = cells[4].strip_suffix(" s").and_then(|it| it.parse().ok());
            // The printed runs of the other cases were not timed one by one.
            let is_timed = cells[4] != "as `case3`";
            assert_eq!(time.unwrap_or(210.0), seconds, "{row}");
            assert_eq!(time.is_some(), is_timed, "{row}");
        }
    }
}
