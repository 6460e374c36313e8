//! Every scalar of a run from its first step to its last, as curves: what they take of memory is bounded. The rows
//! themselves are on the disk.

use super::series::Series;
use crate::record::Columns;
use crate::scene::AnchoringKind;
use crate::simulation::{Report, VesicleChange};

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
    /// Where the anchoring was switched: step and new kind.
    pub marks: Vec<(u64, AnchoringKind)>,
    /// What else than a change of the mesh has happened, and when.
    pub happened: Vec<(f64, Mark)>,
    /// After which steps, and when, the mesh has followed the membrane.
    pub mesh_changes: Vec<(u64, f64)>,
    /// What the energies are compared with: their values at the start, or just after the last switch of
    /// the anchoring, since which their sum can only have fallen.
    pub baseline: Option<Baseline>,
    /// ∫φ⁰.
    pub phase_integral: Option<f64>,
}

/// The energies that later ones are compared with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Baseline {
    /// Their time.
    pub t: f64,
    /// E_tot.
    pub total: f64,
    /// Those of the effects, by name.
    pub energies: Vec<(String, f64)>,
}

impl Baseline {
    fn of(report: &Report) -> Self {
        let energies = report.energies.iter();
        Self {
            t: report.t,
            total: report.total_energy,
            energies: energies.map(|it| (it.name.to_owned(), it.value)).collect(),
        }
    }

    /// The energy of an effect.
    pub fn energy(&self, effect: &str) -> Option<f64> {
        let named = self.energies.iter().find(|(name, _)| name == effect);
        named.map(|(_, value)| *value)
    }
}

/// Something that happened in a run, for its curves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mark {
    /// The mesh has followed the membrane.
    Mesh,
    /// The anchoring was switched.
    Switch(AnchoringKind),
    /// A field was switched.
    Field,
    /// Vesicles have merged, split, ….
    Vesicles(VesicleChange),
    /// The wall was reached.
    Wall,
}

impl Mark {
    /// Its name; none for what happens all the time.
    pub fn name(self) -> Option<&'static str> {
        match self {
            Self::Mesh => None,
            Self::Switch(kind) => Some(kind.name()),
            Self::Field => Some("field"),
            Self::Vesicles(VesicleChange::Merged) => Some("merged"),
            Self::Vesicles(VesicleChange::Split) => Some("split"),
            Self::Vesicles(VesicleChange::Appeared) => Some("appeared"),
            Self::Vesicles(VesicleChange::Vanished) => Some("vanished"),
            Self::Wall => Some("wall"),
        }
    }
}

impl History {
    /// The scalars of a run that resumes a kept one with these rows, and where they are marked.
    pub fn of(
        rows: &Columns,
        switches: &[(u64, AnchoringKind)],
        mesh_changes: &[(u64, f64)],
    ) -> Self {
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
        let energies: Vec<(String, Series)> = energies.collect();
        let row_after = |step: u64| steps.iter().rposition(|there| *there as u64 == step);
        let happened = switches.iter().filter_map(|(step, kind)| {
            let t = times.get(row_after(*step)?)?;
            Some((*t, Mark::Switch(*kind)))
        });
        let last_switch = switches.last().map_or(0, |(step, _)| *step);
        let baseline = row_after(last_switch).and_then(|row| {
            let value = |column: &str| Some(rows.column(column)?[row]);
            let energy = |(name, _): &(String, Series)| {
                let value = value(&format!("E_{name}")).filter(|value| !value.is_nan())?;
                Some((name.clone(), value))
            };
            Some(Baseline {
                t: value("t")?,
                total: value("E_total")?,
                energies: energies.iter().filter_map(energy).collect(),
            })
        });
        Self {
            total_energy: plain("E_total"),
            happened: happened.collect(),
            energies,
            surface_area: plain("B"),
            phase_drift: series("A", 0.0, &|value| value - start.unwrap_or(value)),
            law_residual: series("law_residual", 1.0, &f64::abs),
            cost: Series::default(),
            length: plain("length"),
            waist: plain("waist"),
            width: plain("width"),
            marks: switches.to_vec(),
            mesh_changes: mesh_changes.to_vec(),
            baseline,
            phase_integral: start,
        }
    }

    /// Takes the scalars of the next step, or those of step 0.
    pub fn take(&mut self, report: &Report) {
        self.take_energies(report);
        self.baseline.get_or_insert_with(|| Baseline::of(report));
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

    /// Takes a switch of the anchoring: the energies of the unchanged state, computed again.
    pub fn switch(&mut self, kind: AnchoringKind, report: &Report) {
        self.take_energies(report);
        self.baseline = Some(Baseline::of(report));
        self.marks.push((report.step, kind));
        self.happened.push((report.t, Mark::Switch(kind)));
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

    #[test]
    fn a_switch_is_marked_and_moves_the_baseline() {
        let mut history = History::default();
        history.take(&report(0, &[("bending", 5.0)]));
        history.take(&report(1, &[("bending", 4.0)]));
        let total = |history: &History| history.baseline.as_ref().map(|it| it.total);
        assert_eq!(total(&history), Some(5.0));
        history.switch(
            AnchoringKind::Parallel,
            &report(1, &[("bending", 4.0), ("anchoring", 3.0)]),
        );
        assert_eq!(total(&history), Some(7.0));
        let baseline = history.baseline.as_ref().expect("the last switch");
        assert_eq!(baseline.energy("anchoring"), Some(3.0));
        assert_eq!(
            history.happened,
            [(1.0, Mark::Switch(AnchoringKind::Parallel))]
        );
        assert_eq!(history.marks, [(1, AnchoringKind::Parallel)]);
        assert_eq!(history.total_energy.columns(2, 1.0)[1], Some([4.0, 7.0]));
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
                history.switch(AnchoringKind::Parallel, &report);
                rows.push(&report);
            }
        }
        let mut again = History::of(&rows, &[(7, AnchoringKind::Parallel)], &[(9, 0.5)]);
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
        assert_eq!(again.mesh_changes, [(9, 0.5)]);
        assert_eq!(again.happened, history.happened);
        assert_eq!(again.baseline, history.baseline);
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
