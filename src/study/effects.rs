//! What each effect of a scene costs: the scene is run as it is and with one effect after the other taken
//! away, all of them side by side, and the steps are timed.
//!
//! A price by taking away is what a user would save. It counts what an effect does to the iterations too,
//! which a clock around its formulas would not see; and the prices of two effects that share something
//! (the director) do not add up to that of both.

use serde::{Serialize, Serializer};
use std::time::Duration;

use crate::physics::EFFECTS;
use crate::scene::{ScalarField, Scene};
use crate::simulation::{Phase, Simulation, SimulationError};

use super::clock::median;
use super::memory::held;

/// How much is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Steps before anything is timed: the first ones take more iterations than the rest.
    pub warm_up: u64,
    /// Steps that are timed.
    pub steps: u64,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            warm_up: 10,
            steps: 20,
        }
    }
}

/// What a step of a scene takes, and the run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cost {
    /// The median of the steps; in seconds as JSON.
    #[serde(rename = "step_seconds", serialize_with = "as_seconds")]
    pub step: Duration,
    /// The median of their substeps 1; in seconds as JSON.
    #[serde(rename = "substep_1_seconds", serialize_with = "as_seconds")]
    pub substep_1: Duration,
    /// Iterations of substep 2, a step.
    pub newton: f64,
    /// Krylov iterations, a step.
    pub krylov: f64,
    /// Iterations of substep 1, a step.
    pub director: f64,
    /// Bytes that the run holds; `None` where nobody counts.
    #[serde(rename = "memory_bytes")]
    pub memory: Option<i64>,
}

fn as_seconds<S: Serializer>(duration: &Duration, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(duration.as_secs_f64())
}

/// An effect, and what the scene costs without it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Price {
    /// The effect, or several that go together.
    pub effect: &'static str,
    /// Its energy after the steps of the scene as it is; `None` where it has none of its own.
    pub energy: Option<f64>,
    /// What else has to go with it.
    pub with_it: Vec<&'static str>,
    /// Without it.
    pub without: Cost,
}

/// What the effects of a scene cost.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prices {
    /// The scene as it is.
    pub whole: Cost,
    /// E_total after its steps.
    pub total_energy: f64,
    /// The energy of bending.
    pub bending: f64,
    /// The membrane that does nothing but bend.
    pub alone: Cost,
    /// Each effect that can be taken away.
    pub effects: Vec<Price>,
    /// Where the scene's steps are chosen: the length of those that were timed in their place.
    pub fixed_step: Option<f64>,
}

/// How far a study is: steps made, of how many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Steps made.
    pub done: u64,
    /// Of how many.
    pub of: u64,
}

/// The spontaneous curvature, which is no effect of its own but can be taken away like one.
const CURVATURE: &str = "curvature";

/// What can be taken away from a scene: the spontaneous curvature, and the effects that have a table.
fn removable() -> impl Iterator<Item = &'static str> {
    [CURVATURE].into_iter().chain(EFFECTS.iter().copied())
}

/// Takes an effect away from a scene; whether it was there.
fn remove(scene: &mut Scene, effect: &str) -> bool {
    if effect != CURVATURE {
        return scene.remove_effect(effect);
    }
    let k = &mut scene.membrane.spontaneous_curvature;
    let none = ScalarField::Constant(0.0);
    std::mem::replace(k, none.clone()) != none
}

/// A scene without an effect, if it has it.
fn without(scene: &Scene, effect: &str) -> Option<Scene> {
    let mut rest = scene.clone();
    remove(&mut rest, effect).then_some(rest)
}

/// Measures the scene and everything that it is without one of its effects. The runs take turns, step
/// by step, so that what disturbs the machine disturbs all of them.
///
/// `watch` is called while the runs are set up, after every step and within one that takes long, and says
/// whether to go on; `None` where it did not.
///
/// # Errors
/// [`SimulationError`]: one of the scenes cannot be run.
pub fn prices(
    scene: &Scene,
    plan: Plan,
    watch: &mut dyn FnMut(Progress) -> bool,
) -> Result<Option<Prices>, SimulationError> {
    // Chosen steps would be of another length without an effect: all take the one that is tried first.
    let mut scene = scene.clone();
    let fixed_step = scene.time.tolerance.take().map(|_| scene.time.step);
    let scene = &scene;
    let removed: Vec<(&'static str, Scene)> = removable()
        .filter_map(|name| Some((name, without(scene, name)?)))
        .collect();
    let mut alone = scene.clone();
    for effect in removable() {
        remove(&mut alone, effect);
    }
    let scenes = [scene, &alone].into_iter();
    let scenes = scenes.chain(removed.iter().map(|(_, scene)| scene));
    let of = (plan.warm_up + plan.steps) * (2 + removed.len() as u64);
    let mut done = 0;
    let mut runs = Vec::new();
    for scene in scenes {
        match Run::new(scene, &mut || !watch(Progress { done, of })) {
            Err(SimulationError::Ended) => return Ok(None),
            run => runs.push(run?),
        }
    }

    for step in 0..plan.warm_up + plan.steps {
        for run in &mut runs {
            let mut go_on = || watch(Progress { done, of });
            if !run.advance(step >= plan.warm_up, &mut go_on)? {
                return Ok(None);
            }
            done += 1;
            if !watch(Progress { done, of }) {
                return Ok(None);
            }
        }
    }

    let whole = runs[0].simulation.report();
    let energy = |name: &str| {
        let energy = whole.energies.iter().find(|energy| energy.name == name);
        energy.map(|energy| energy.value)
    };
    let has = |scene: &Scene, effect: &str| without(scene, effect).is_some();
    let effects = removed
        .iter()
        .zip(&runs[2..])
        .map(|((effect, rest), run)| Price {
            effect,
            energy: energy(effect),
            with_it: removed
                .iter()
                .map(|(other, _)| *other)
                .filter(|other| other != effect && !has(rest, other))
                .collect(),
            without: run.cost(),
        });
    Ok(Some(Prices {
        whole: runs[0].cost(),
        total_energy: whole.total_energy,
        bending: energy("bending").unwrap_or(f64::NAN),
        alone: runs[1].cost(),
        effects: effects.collect(),
        fixed_step,
    }))
}

/// One of the runs, with what it has taken.
struct Run {
    simulation: Simulation,
    steps: Vec<Duration>,
    substeps_1: Vec<Duration>,
    iterations: [u64; 3],
    memory: i64,
}

impl Run {
    fn new(scene: &Scene, leave: &mut dyn FnMut() -> bool) -> Result<Self, SimulationError> {
        let before = held();
        let simulation = Simulation::new_unless(scene, &mut |_| leave())?;
        Ok(Self {
            simulation,
            steps: Vec::new(),
            substeps_1: Vec::new(),
            iterations: [0; 3],
            memory: held() - before,
        })
    }

    /// Takes a step, unless `go_on` says otherwise within it: whether it was taken.
    fn advance(
        &mut self,
        counts: bool,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<bool, SimulationError> {
        let before = held();
        let mut is_ended = false;
        // It is also left for events, which nobody reads here.
        while !self.simulation.advance_unless(&mut |_| {
            is_ended = !go_on();
            is_ended
        })? {
            if is_ended {
                return Ok(false);
            }
        }
        self.memory += held() - before;
        let report = self.simulation.report();
        if counts {
            self.steps.push(report.costs.total());
            self.substeps_1.push(report.costs.of(Phase::Director));
            let iterations = [report.newton, report.krylov, report.director_iterations];
            for (sum, count) in self.iterations.iter_mut().zip(iterations) {
                *sum += u64::from(count);
            }
        }
        Ok(true)
    }

    fn cost(&self) -> Cost {
        let mean = |count: u64| count as f64 / self.steps.len().max(1) as f64;
        let [newton, krylov, director] = self.iterations.map(mean);
        Cost {
            step: median(self.steps.iter().copied(), Ord::cmp),
            substep_1: median(self.substeps_1.iter().copied(), Ord::cmp),
            newton,
            krylov,
            director,
            memory: (self.memory != 0).then_some(self.memory),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(text: &str) -> Scene {
        let text = format!("mesh.cells = 12\nmembrane.interface_width = 0.08\n{text}");
        Scene::of_text(&text, &[])
    }

    const PLAN: Plan = Plan {
        warm_up: 1,
        steps: 3,
    };

    #[test]
    fn each_effect_is_taken_away_once_and_what_needs_it_goes_with_it() {
        let scene = scene("[area]\n[nematic]\n[anchoring]\n[pull]\npotential = 'x'");
        let mut seen = Vec::new();
        let prices = prices(&scene, PLAN, &mut |progress| {
            // Nothing is done while the runs are set up.
            seen.extend(Some(progress.done).filter(|done| *done > 0));
            true
        })
        .expect("runs")
        .expect("not ended");
        let names: Vec<&str> = prices.effects.iter().map(|price| price.effect).collect();
        assert_eq!(names, ["area", "nematic", "pull", "anchoring"]);
        assert_eq!(prices.effects[1].with_it, ["anchoring"]);
        assert!(prices.effects[3].with_it.is_empty());
        assert!(prices.effects.iter().all(|price| price.energy.is_some()));
        assert_eq!(seen, (1..=6 * 4).collect::<Vec<u64>>());
        let nematic = &prices.effects[1];
        assert_eq!(nematic.without.director, 0.0);
        assert!(prices.whole.director >= 1.0 && prices.whole.newton >= 1.0);
        assert_eq!(prices.alone.director, 0.0);
        let energies = prices.effects.iter().filter_map(|price| price.energy);
        let sum = prices.bending + energies.sum::<f64>();
        assert!((sum - prices.total_energy).abs() < 1e-12 * sum.abs());
    }

    #[test]
    fn a_membrane_that_only_bends_has_nothing_to_take_away() {
        let prices = prices(&scene(""), PLAN, &mut |_| true);
        assert_eq!(prices.expect("runs").expect("not ended").effects, []);
    }

    #[test]
    fn a_study_can_be_ended() {
        let ended = prices(&scene("[area]"), PLAN, &mut |progress| progress.done < 2);
        assert_eq!(ended.expect("runs"), None);
        let in_set_up = prices(&scene("[area]"), PLAN, &mut |progress| progress.done > 0);
        assert_eq!(in_set_up.expect("runs"), None);
    }

    #[test]
    fn a_study_can_be_ended_within_a_hard_step() {
        let hard = "membrane.spontaneous_curvature = '1e6*sign(x - 0.5)'\n[area]\n[time]\nstep = 1e-6\nend = 1.0";
        let scene = scene(hard);
        let (mut asked, mut done) = (0, 0);
        let ended = prices(&scene, PLAN, &mut |progress| {
            (asked, done) = (asked + 1, progress.done);
            asked < 10
        });
        // No step was at its end.
        assert_eq!((ended.expect("runs"), asked, done), (None, 10, 0));
    }
}
