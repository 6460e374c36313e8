//! Every scalar of a run from its first step to its last, as curves: what they take of memory is bounded. The rows
//! themselves are on the disk.

use super::series::Series;
use crate::record::{Columns, MarkKind, RunMark};
use crate::simulation::Report;

/// Every scalar over the whole run.
#[derive(Debug, Clone, Default)]
pub struct History {
    /// E_tot.
    pub total_energy: Series,
    /// The energies of the effects that the scene has, by name.
    pub energies: Vec<(String, Series)>,
    /// B.
    pub surface_area: Series,
    /// ∫φ − ∫φ⁰.
    pub phase_drift: Series,
    /// |law_residual|.
    pub law_residual: Series,
    /// Milliseconds a step.
    pub cost: Series,
    /// Length, waist and greatest width of the vesicle.
    pub length: Series,
    /// See `length`.
    pub waist: Series,
    /// See `length`.
    pub width: Series,
    /// Where something has happened that is marked.
    pub marks: Vec<RunMark>,
    /// ∫φ⁰.
    pub phase_integral: Option<f64>,
}

impl History {
    /// The scalars of a run that resumes a kept one with these rows, and where they are marked.
    pub fn of(rows: &Columns, marks: &[RunMark]) -> Self {
        let steps = rows.column("step").unwrap_or_default();
        let times = rows.column("t").unwrap_or_default();
        let series = |name: &str, from: f64, change: &dyn Fn(f64) -> f64| {
            let mut series = Series::default();
            let values = rows.column(name).unwrap_or_default();
            for ((step, t), value) in steps.iter().zip(times).zip(values) {
                if *step >= from && !value.is_nan() {
                    series.push(*t, change(*value));
                }
            }
            series
        };
        let plain = |name: &str| series(name, 0.0, &|value| value);
        let start = rows.column("A").and_then(|values| values.first().copied());
        let energies = rows.names().filter_map(|column| {
            let name = column.strip_prefix("E_").filter(|name| *name != "total")?;
            rows.known(column)?;
            Some((name.to_owned(), plain(column)))
        });
        Self {
            total_energy: plain("E_total"),
            energies: energies.collect(),
            surface_area: plain("B"),
            phase_drift: series("A", 0.0, &|value| value - start.unwrap_or(value)),
            law_residual: series("law_residual", 1.0, &f64::abs),
            cost: Series::default(),
            length: plain("length"),
            waist: plain("waist"),
            width: plain("width"),
            marks: marks.to_vec(),
            phase_integral: start,
        }
    }

    /// Takes the scalars of the next step, or those of step 0.
    pub fn take(&mut self, report: &Report) {
        self.take_energies(report);
        let t = report.t;
        self.surface_area.push(t, report.surface_area);
        let start = *self.phase_integral.get_or_insert(report.phase_integral);
        self.phase_drift.push(t, report.phase_integral - start);
        if let Some(outline) = report.outline() {
            self.length.push(t, outline.length);
            self.waist.push(t, outline.waist);
            self.width.push(t, outline.width);
        }
        // Neither law nor cost belongs to the initial state.
        if report.step > 0 {
            self.law_residual.push(t, report.law_residual.abs());
            let seconds = report.costs.total().as_secs_f64();
            self.cost.push(t, 1e3 * seconds);
        }
    }

    /// What E_tot at a step is compared with: its value at the start and the work of the changes since. From there it can
    /// only have fallen. `None` where that work is not known.
    pub fn energy_at_start(&self, step: u64) -> Option<f64> {
        let mut energy = self.total_energy.at_start()?;
        for mark in self.marks.iter().filter(|mark| mark.step < step) {
            if let MarkKind::Change { work, .. } = mark.kind {
                energy += work?;
            }
        }
        Some(energy)
    }

    fn take_energies(&mut self, report: &Report) {
        self.total_energy.push(report.t, report.total_energy);
        for energy in &report.energies {
            let known = self
                .energies
                .iter_mut()
                .find(|(name, _)| *name == energy.name);
            match known {
                Some((_, series)) => series.push(report.t, energy.value),
                None => {
                    let mut series = Series::default();
                    series.push(report.t, energy.value);
                    self.energies.push((energy.name.to_owned(), series));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::NamedValue;

    fn report(step: u64, energies: &[(&'static str, f64)]) -> Report {
        let named = |&(name, value): &(&'static str, f64)| NamedValue { name, value };
        Report {
            step,
            t: step as f64,
            total_energy: energies.iter().map(|(_, value)| value).sum(),
            energies: energies.iter().map(named).collect(),
            phase_integral: 0.5 + step as f64,
            law_residual: -1e-12,
            ..Report::default()
        }
    }

    fn change(step: u64, work: Option<f64>) -> RunMark {
        RunMark {
            step,
            t: 0.5,
            kind: MarkKind::Change {
                label: "parallel".to_owned(),
                work,
            },
        }
    }

    #[test]
    fn the_energy_is_compared_with_the_start_and_the_work_since() {
        let mut history = History::default();
        history.take(&report(0, &[("bending", 5.0)]));
        history.take(&report(1, &[("bending", 4.0)]));
        history.marks.push(change(1, Some(3.0)));
        history.take(&report(2, &[("bending", 3.5), ("anchoring", 3.0)]));
        assert_eq!(history.energy_at_start(1), Some(5.0));
        assert_eq!(history.energy_at_start(2), Some(8.0));
        history.marks.push(change(2, None));
        assert_eq!(history.energy_at_start(2), Some(8.0));
        assert_eq!(history.energy_at_start(3), None);
        let names: Vec<_> = history
            .energies
            .iter()
            .map(|(name, _)| name.as_str())
            .collect();
        assert_eq!(names, ["bending", "anchoring"]);
    }

    #[test]
    fn the_scalars_of_a_kept_run_are_those_that_it_had() {
        let mut history = History::default();
        let mut rows = Columns::default();
        for step in 0..3000 {
            let report = report(step, &[("bending", 5.0 - step as f64 * 1e-3)]);
            history.take(&report);
            rows.push(&report);
            if step == 7 {
                history.marks.push(change(7, Some(1.0)));
            }
        }
        let mut again = History::of(&rows, &history.marks);
        // The last step is reported again.
        again.take(&report(2999, &[("bending", 5.0 - 2.999)]));
        let curves = |history: &History| {
            [
                &history.total_energy,
                &history.energies[0].1,
                &history.phase_drift,
                &history.law_residual,
            ]
            .map(|series| series.columns(90, 3000.0))
        };
        assert_eq!(curves(&again), curves(&history));
        assert_eq!(again.energies.len(), history.energies.len());
        assert_eq!(again.marks, history.marks);
        assert_eq!(again.energy_at_start(9), history.energy_at_start(9));
        assert_eq!(again.phase_integral, history.phase_integral);
    }

    #[test]
    fn the_drift_is_relative_and_the_law_begins_with_the_first_step() {
        let mut history = History::default();
        history.take(&report(0, &[]));
        assert_eq!(history.law_residual.last(), None);
        assert_eq!(history.cost.last(), None);
        history.take(&report(2, &[]));
        assert_eq!(history.phase_drift.last(), Some(2.0));
        assert_eq!(history.law_residual.last(), Some(1e-12));
    }
}
