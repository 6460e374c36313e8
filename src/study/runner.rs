//! The runs of a study, within a budget.
//!
//! A ladder of meshes (a quarter, a half and the whole of the scene's cells) and tolerances, the
//! scene's own choice, another quadrature and another iteration. The first steps on the scene's mesh are tried
//! first; from what they took the prices of runs are estimated, and better from each run that is made. An answer
//! takes a run on the scene's own mesh and a reference on a finer one: what they take is set aside, and where the
//! budget does not pay for them the study ends at once and names one that does. Of the others a run that would not
//! fit into what is left of the budget is left out, the cheapest comes first; half of the budget is for the
//! reference, on the finest mesh that it pays for.
//! A run that fails, or is stopped, stays in the study and says so.

use super::discretisation::{Discretisation, fixed_mesh};
use super::evaluation::evaluate;
use super::measure::{Failure, Measurement, measure};
use super::plan::{Known, discretisations, estimated_time, known, own_mesh, references};
use super::recorded_runs::ComparedRuns;
use super::report::Study;
use super::run_estimate::{Foresight, LONGEST, Unsolved, run_price_within};
use crate::scene::Scene;
use crate::simulation::SimulationError;
use std::time::{Duration, Instant};
use thiserror::Error;

/// How long a study may take, and how thorough it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// On the wall.
    pub time: Duration,
    /// Finer meshes and tolerances: with a large budget.
    pub full: bool,
}

impl Budget {
    /// The largest that can be given, in seconds.
    pub const MOST: u64 = 1_000_000;
}

/// What is reported of a study on its way.
#[derive(Debug, Clone, Copy)]
pub enum StudyNews<'a> {
    /// The first steps on the scene's mesh are tried, for what runs will take.
    FirstSteps,
    /// A run is under way, and how far it is, from 0 to 1.
    Run(&'a Discretisation, f64),
    /// Something to know before it goes on.
    Note(&'a str),
}

/// Why there is no study.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StudyError {
    /// A run that there must be cannot be made.
    #[error("a run with {run}, without which there is no answer, fails: {source}")]
    Failed {
        /// The run.
        run: String,
        /// Why.
        source: SimulationError,
    },
    /// A step cannot be solved.
    #[error(
        "a run with {run}: {unsolved}. No --budget helps where it is a step that fails: see what `vesica check` \
         says of the scene"
    )]
    Unsolved {
        /// The run.
        run: String,
        /// How far it came.
        unsolved: Unsolved,
    },
    /// The first run did not come to its end in time.
    #[error(
        "the cheapest run, with {run}, was stopped after {seconds:.0} s, at {:.0} % of its way: raise --budget, or \
         give a coarser mesh",
        100.0 * share
    )]
    TooLong {
        /// The run.
        run: String,
        /// How long it took.
        seconds: f64,
        /// How far it came.
        share: f64,
    },
    /// The budget does not pay for an answer.
    #[error(
        "a budget of {budget:.0} s is too little: a run with {own} and a reference with {reference} take \
         about {price:.0} s, and {left:.0} s are left; {}",
        remedy(*least, better)
    )]
    Budget {
        /// What there is, in seconds.
        budget: f64,
        /// The run on the scene's own mesh.
        own: String,
        /// The cheapest reference.
        reference: String,
        /// What they are to take, in seconds.
        price: f64,
        /// What is left of the budget, in seconds.
        left: f64,
        /// With how much there is an answer.
        least: f64,
        /// With how much there is one with a better reference, and on which mesh that is.
        better: Option<(f64, String)>,
    },
    /// Whoever watches has ended it.
    #[error("the study was ended before its first run was done")]
    Ended,
}

/// What to do about a budget that does not pay for an answer.
fn remedy(least: f64, better: &Option<(f64, String)>) -> String {
    let most = Budget::MOST as f64;
    match better {
        _ if least > most => format!(
            "no --budget up to {most:.0} pays for that: give a coarser mesh, or an earlier time.end"
        ),
        Some((better, mesh)) if *better <= most => format!(
            "give --budget {better:.0}, for a reference ({mesh}) whose own error is a small part of what it \
             measures; --budget {least:.0}, for one whose error is a third of that or more; or a coarser mesh"
        ),
        _ => format!("give --budget {least:.0}, or a coarser mesh"),
    }
}

/// An estimate of a run's price may be too low by this before the run is stopped.
const PATIENCE: f64 = 2.0;

/// The share of the budget that the reference may take.
const REFERENCE_SHARE: f64 = 0.5;

/// A run that takes a smaller share of the budget than this is made before it is known whether the budget
/// is enough: it makes the estimates better.
const EASY: f64 = 0.05;

/// The first steps on the scene's mesh may take so long before anything else is computed,
const FIRST_STEPS: Duration = Duration::from_secs(5);

/// and this part of the budget.
const FIRST_PART: u32 = 4;

/// A budget that is recommended is so many times what the runs are expected to take.
const MARGIN: f64 = 1.3;

/// Makes the runs of a study, and puts those beside them that are finished. `watch` hears what is being
/// done, and says whether to go on; without it the study ends with what there is.
///
/// # Errors
/// [`StudyError`]: there is nothing to report.
pub fn study(
    scene: &Scene,
    budget: Budget,
    finished: ComparedRuns,
    watch: &mut dyn FnMut(StudyNews) -> bool,
) -> Result<Study, StudyError> {
    let own = Discretisation::of(scene);
    let is_own_there = finished.beside.iter().any(|run| run.is_own);
    let mut rest = discretisations(scene, budget.full);
    if is_own_there {
        rest.retain(|choice| *choice != own);
    }
    let mut runs = Runs {
        scene,
        budget,
        begun: Instant::now(),
        own_mesh: (!is_own_there).then(|| own_mesh(&own)),
        references: match finished.against {
            None => references(scene, budget.full),
            Some(_) => Vec::new(),
        },
        done: Vec::new(),
        foreseen: Vec::new(),
        watch,
        ended: false,
    };
    let is_enough = finished.against.is_some() && !finished.beside.is_empty();
    let mut is_checked = is_enough;
    // What cannot be is refused before anything is computed in vain.
    let limit = FIRST_STEPS.min(budget.time / FIRST_PART);
    if !is_enough && runs.foresee(limit)? {
        runs.check_budget()?;
        if !is_own_there {
            runs.foresee_own_choice(own, limit / 2);
        }
        runs.tell_of_reference();
        is_checked = true;
    }
    if runs.ended {
        return Err(StudyError::Ended);
    }
    let mut made = 0;
    while !runs.ended {
        // The cheap ones first, so that prices are known better and better. The first in the list is the
        // cheapest as long as nothing is known.
        rest.sort_by(|a, b| runs.price(a).total_cmp(&runs.price(b)));
        let is_easy =
            |choice: &Discretisation| runs.price(choice) <= EASY * budget.time.as_secs_f64();
        if made > 0 && !is_checked && !rest.first().is_some_and(is_easy) {
            is_checked = true;
            if runs.check_budget().is_err() {
                runs.foresee(LONGEST)?;
                if runs.ended {
                    break;
                }
                runs.check_budget()?;
                runs.tell_of_reference();
                // The order may be another one now.
                continue;
            }
        }
        if rest.is_empty() {
            break;
        }
        let next = rest.remove(0);
        let room = runs.room(&next);
        if made > 0 && runs.price(&next) > room {
            continue;
        }
        runs.make(next, if made == 0 { runs.left(1.0) } else { room });
        made += 1;
        let is_coarser = next.cells < own.cells;
        if is_coarser && runs.has_failed_last() {
            // A mesh may be too coarse for the vesicle, or for its interface, with any steps.
            rest.retain(|choice| choice.cells != next.cells);
        } else if !is_enough && !is_coarser {
            runs.check_any_done()?;
        }
    }
    if !is_enough {
        runs.check_any_done()?;
    }
    let reference = match finished.against {
        None => runs
            .reference()
            .map(|(choice, measured)| (None, choice, measured)),
        Some(run) => Some((Some(run.name), run.choice, run.measurement)),
    };
    let mut remarks = Vec::new();
    if let Some(reason) = fixed_mesh(scene) {
        remarks.push(format!(
            "The mesh is the scene's own throughout, for {reason}: the errors are those of the steps alone."
        ));
    }
    let is_made = runs.done.iter().any(|(choice, _)| *choice == own);
    if !is_made && !is_own_there {
        remarks.push(runs.without_own_steps(&own));
    }
    let Runs { done, .. } = runs;
    Ok(evaluate(
        scene,
        &own,
        done,
        finished.beside,
        reference,
        remarks,
    ))
}

struct Runs<'a> {
    scene: &'a Scene,
    budget: Budget,
    begun: Instant,
    /// The run on the scene's mesh that there must be.
    own_mesh: Option<Discretisation>,
    /// What the others may be measured against, the most accurate first.
    references: Vec<Discretisation>,
    done: Vec<(Discretisation, Measurement)>,
    /// What the run on the scene's mesh, and the scene's own choice, are expected to take, by their first steps.
    foreseen: Vec<Known>,
    watch: &'a mut dyn FnMut(StudyNews) -> bool,
    ended: bool,
}

impl Runs<'_> {
    /// What is left of a share of the budget, in seconds.
    fn left(&self, share: f64) -> f64 {
        share * self.budget.time.as_secs_f64() - self.begun.elapsed().as_secs_f64()
    }

    /// The share of the budget that is not for the reference.
    fn share(&self) -> f64 {
        match self.references.is_empty() {
            true => 1.0,
            false => 1.0 - REFERENCE_SHARE,
        }
    }

    fn price(&self, choice: &Discretisation) -> f64 {
        let known = self.done.iter().filter_map(known);
        let known = known.chain(self.foreseen.iter().copied());
        estimated_time(self.scene, choice, known)
    }

    /// Makes the first steps of the run on the scene's mesh, in so much time at most: they tell more
    /// than runs on meshes that may be too coarse for the scene. Whether they told what it will take.
    ///
    /// # Errors
    /// [`StudyError`]: the run cannot be made at all.
    fn foresee(&mut self, limit: Duration) -> Result<bool, StudyError> {
        let (Some(choice), _) = self.missing() else {
            return Ok(false);
        };
        if !self.foreseen.is_empty() {
            return Ok(true);
        }
        let left = Duration::try_from_secs_f64(self.left(1.0)).unwrap_or_default();
        let run = choice.to_string();
        match self.make_first_steps(choice, limit.min(left)) {
            Ok(Foresight::Price(_)) => Ok(true),
            Ok(Foresight::Unsolved(unsolved)) if unsolved.is_hopeless() => {
                Err(StudyError::Unsolved { run, unsolved })
            }
            Ok(_) => Ok(false),
            Err(source) => Err(StudyError::Failed { run, source }),
        }
    }

    /// The same of the scene's own choice, where that is another: what a fixed step takes does not follow from what chosen ones
    /// do. Where it is not found out it is estimated as all others are.
    fn foresee_own_choice(&mut self, own: Discretisation, limit: Duration) {
        let is_known = self.foreseen.iter().any(|(choice, _)| *choice == own);
        if !is_known && !self.ended {
            self.make_first_steps(own, limit).ok();
        }
    }

    fn make_first_steps(
        &mut self,
        choice: Discretisation,
        limit: Duration,
    ) -> Result<Foresight, SimulationError> {
        let (watch, mut is_ended) = (&mut *self.watch, false);
        let mut go_on = || {
            is_ended |= !watch(StudyNews::FirstSteps);
            !is_ended
        };
        let foresight = run_price_within(&choice.applied_to(self.scene), limit, &mut go_on);
        self.ended |= is_ended;
        if let Ok(Foresight::Price(price)) = &foresight {
            self.foreseen.push((choice, price.seconds));
        }
        foresight
    }

    /// Which runs there must be still, and what they take: that on the scene's mesh, and a reference: on the
    /// finest mesh that the budget has room for.
    fn missing(&self) -> (Option<Discretisation>, Option<Discretisation>) {
        let is_made =
            |wanted: &Discretisation| self.done.iter().any(|(choice, _)| choice == wanted);
        let own = self.own_mesh.filter(|own| !is_made(own));
        let left = self.left(1.0) - own.map_or(0.0, |own| self.price(&own));
        let fits = |choice: &&Discretisation| self.price(choice) <= left;
        let finest = self.references.iter().filter(fits).map(|it| it.cells).max();
        let on_finest = |choice: &&Discretisation| finest.is_none_or(|cells| cells == choice.cells);
        let candidates = self.references.iter().filter(on_finest);
        let cheapest = candidates.min_by(|a, b| self.price(a).total_cmp(&self.price(b)));
        (own, cheapest.copied())
    }

    /// How long a run may take, so that there is time for those that there must be.
    fn room(&self, next: &Discretisation) -> f64 {
        let (own_mesh, reference) = self.missing();
        let price =
            |choice: Option<Discretisation>| choice.map_or(0.0, |choice| self.price(&choice));
        let reference = price(reference);
        if own_mesh == Some(*next) {
            return self.left(1.0) - reference;
        }
        let own_mesh = price(own_mesh);
        let left = self.left(self.share()) - own_mesh;
        left.min(self.left(1.0) - own_mesh - reference)
    }

    /// Whether the budget pays for an answer.
    fn check_budget(&self) -> Result<(), StudyError> {
        let (own_mesh, reference) = self.missing();
        let own_price = own_mesh.map_or(0.0, |choice| self.price(&choice));
        let price = own_price + reference.map_or(0.0, |choice| self.price(&choice));
        if price <= self.left(1.0) || !price.is_finite() {
            return Ok(());
        }
        let words = |choice: Option<Discretisation>| {
            choice.map_or("what there is".to_owned(), |it| it.to_string())
        };
        Err(StudyError::Budget {
            budget: self.budget.time.as_secs_f64(),
            own: words(own_mesh.or(self.own_mesh)),
            reference: words(reference),
            price,
            left: self.left(1.0).max(0.0),
            least: self.advised(price),
            better: self.better(reference.as_ref(), own_price),
        })
    }

    /// The budget that has room for what takes so long still.
    fn advised(&self, price: f64) -> f64 {
        round_up(MARGIN * (self.begun.elapsed().as_secs_f64() + price))
    }

    /// The budget for a reference on a finer mesh than this one's, with a run on the scene's mesh that takes so long,
    /// and that mesh.
    fn better(&self, reference: Option<&Discretisation>, own_price: f64) -> Option<(f64, String)> {
        let finest = self.references.iter().map(|choice| choice.cells).max()?;
        if reference.is_none_or(|reference| reference.cells >= finest) {
            return None;
        }
        let on_finest = self.references.iter().filter(|it| it.cells == finest);
        let cheapest = on_finest.min_by(|a, b| self.price(a).total_cmp(&self.price(b)))?;
        let budget = self.advised(own_price + self.price(cheapest));
        Some((budget, cheapest.mesh.words(cheapest.cells)))
    }

    /// Says beforehand where the reference will be no good measure.
    fn tell_of_reference(&mut self) {
        let (own_mesh, reference) = self.missing();
        let own_price = own_mesh.map_or(0.0, |choice| self.price(&choice));
        let Some((better, mesh)) = self.better(reference.as_ref(), own_price) else {
            return;
        };
        let reference = reference.map_or(String::new(), |it| it.mesh.words(it.cells));
        let mut note = format!(
            "the budget pays for a reference with {reference}, whose own error may be a third of what it measures, \
             or more"
        );
        if better <= Budget::MOST as f64 {
            note += &format!("; a --budget of {better:.0} pays for one with {mesh}");
        }
        self.ended |= !(self.watch)(StudyNews::Note(&note));
    }

    /// Whether the last run has failed.
    fn has_failed_last(&self) -> bool {
        let last = self.done.last();
        last.is_some_and(|(_, measured)| matches!(measured.outcome, Err(Failure::Failed(_))))
    }

    /// Whether any run has come to its end so far.
    ///
    /// # Errors
    /// [`StudyError`]: none has, and why the last one has not.
    fn check_any_done(&self) -> Result<(), StudyError> {
        let Some((choice, measured)) = self.done.last() else {
            return Ok(());
        };
        if self
            .done
            .iter()
            .any(|(_, measured)| measured.outcome.is_ok())
        {
            return Ok(());
        }
        let (run, seconds) = (choice.to_string(), measured.seconds);
        match &measured.outcome {
            Ok(_) => Ok(()),
            Err(Failure::Ended) => Err(StudyError::Ended),
            Err(Failure::Failed(source)) => {
                let source = source.clone();
                Err(StudyError::Failed { run, source })
            }
            Err(Failure::TooLong) => {
                let underway = measured.underway;
                let unsolved = Unsolved { seconds, underway };
                if unsolved.is_stuck() {
                    return Err(StudyError::Unsolved { run, unsolved });
                }
                self.check_budget()?;
                let share = measured.share;
                Err(StudyError::TooLong {
                    run,
                    seconds,
                    share,
                })
            }
        }
    }

    /// That the scene's own steps were not run, and with which budget they are.
    fn without_own_steps(&self, own: &Discretisation) -> String {
        let price = self.price(own);
        let spent = self.begun.elapsed().as_secs_f64();
        let enough = round_up(MARGIN * (spent + price) / self.share());
        let hint = match enough <= Budget::MOST as f64 && !self.ended {
            true => format!(
                ": they take about {price:.0} s, and a --budget of {enough:.0} has room for them"
            ),
            false => String::new(),
        };
        format!("The scene's own choice, {own}, was not run{hint}.")
    }

    fn measure(&mut self, choice: &Discretisation, seconds: f64) -> Measurement {
        let limit = Duration::try_from_secs_f64(seconds).unwrap_or_default();
        let watch = &mut *self.watch;
        let measured = measure(self.scene, choice, limit, &mut |done| {
            watch(StudyNews::Run(choice, done))
        });
        self.ended |= measured.outcome.as_ref().err() == Some(&Failure::Ended);
        measured
    }

    fn make(&mut self, choice: Discretisation, seconds: f64) {
        let measured = self.measure(&choice, seconds);
        self.done.push((choice, measured));
    }

    /// The most accurate run that the rest of the budget pays for.
    fn reference(&mut self) -> Option<(Discretisation, Measurement)> {
        for choice in self.references.clone() {
            if self.ended {
                return None;
            }
            if self.price(&choice) > self.left(1.0) {
                continue;
            }
            let measured = self.measure(&choice, self.left(PATIENCE));
            if measured.outcome.is_ok() {
                return Some((choice, measured));
            }
        }
        None
    }
}

/// Up to the next number of two digits.
fn round_up(seconds: f64) -> f64 {
    let unit = 10_f64.powf((seconds.max(1.0).log10().floor() - 1.0).max(0.0));
    (seconds / unit).ceil() * unit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::{CALM, scene};

    fn runs<'a>(
        scene: &'a Scene,
        seconds: f64,
        watch: &'a mut dyn FnMut(StudyNews) -> bool,
    ) -> Runs<'a> {
        let own = own_mesh(&Discretisation::of(scene));
        let budget = Budget {
            time: Duration::from_secs_f64(seconds),
            full: false,
        };
        Runs {
            scene,
            budget,
            begun: Instant::now(),
            own_mesh: Some(own),
            references: references(scene, false),
            done: Vec::new(),
            foreseen: vec![(own, 1000.0)],
            watch,
            ended: false,
        }
    }

    #[test]
    fn a_budget_without_an_answer_is_refused_with_one_that_has_it() {
        let scene = scene(CALM);
        let mut watch = |_: StudyNews| true;
        let error = runs(&scene, 3000.0, &mut watch).check_budget();
        let Err(StudyError::Budget {
            price,
            least,
            better: Some((better, _)),
            ..
        }) = &error
        else {
            panic!("{error:?}");
        };
        // With twice the cells, and with three times as many.
        let [twice, thrice] = [2.0_f64, 3.0].map(|times| 1000.0 * (1.0 + times.powf(2.6)));
        assert!((price / twice - 1.0).abs() < 1e-9, "{price}");
        assert!((1.3 * thrice..1.4 * thrice).contains(better), "{better}");
        let (least, better) = (*least, *better);
        let told = error.expect_err("it is one").to_string();
        let budgets = [least, better].map(|budget| format!("--budget {budget:.0}"));
        let words = [
            "3000 s is too little",
            "24 cells and tolerance 1e-3",
            "48 cells",
            "72 cells",
        ];
        for word in words.iter().chain(&budgets.each_ref().map(|it| &**it)) {
            assert!(told.contains(word), "{told}");
        }
        // What each of them pays for is set aside, and where it is not the best that is said beforehand.
        for (budget, cells, notes) in [(least, 48, 1), (better, 72, 0)] {
            let mut told = Vec::new();
            let mut watch = |news: StudyNews| {
                if let StudyNews::Note(words) = news {
                    told.push(words.to_owned());
                }
                true
            };
            let mut runs = runs(&scene, budget, &mut watch);
            assert_eq!(runs.check_budget(), Ok(()));
            assert_eq!(runs.missing().1.map(|it| it.cells), Some(cells));
            runs.tell_of_reference();
            drop(runs);
            assert_eq!(told.len(), notes, "{told:?}");
            assert!(
                told.iter()
                    .all(|it| it.contains("a third") && it.contains("72 cells"))
            );
        }
    }

    #[test]
    fn no_budget_is_advised_that_cannot_be_given() {
        let scene = scene(CALM);
        for (own, advised) in [
            (1e5, "--budget 920000, or a coarser mesh"),
            (1e6, "no --budget up to 1000000"),
        ] {
            let mut watch = |_: StudyNews| true;
            let mut runs = runs(&scene, 10.0, &mut watch);
            runs.foreseen.iter_mut().for_each(|(_, price)| *price = own);
            let told = runs.check_budget().expect_err("too little").to_string();
            assert!(told.contains(advised), "{told}");
            let words = runs.without_own_steps(&own_mesh(&Discretisation::of(&scene)));
            assert_eq!(words.ends_with("was not run."), own == 1e6, "{words}");
        }
    }

    #[test]
    fn a_step_that_cannot_be_solved_is_no_matter_of_the_budget() {
        let text = "vesicle = { shape = 'circle', radius = 0.3 }
            mesh.cells = 12
            membrane.interface_width = 0.1
            solver.law_tolerance = 1e-300
            area = {}
            time = { tolerance = 1e-3, end = 1e-4 }";
        let scene = Scene::of_text(text, &[]);
        let budget = Budget {
            time: Duration::from_secs(8),
            full: false,
        };
        let error = study(&scene, budget, ComparedRuns::default(), &mut |_| true);
        // By which limit it is left depends on the machine: that it is a step that fails is reported in any case.
        let told = error.expect_err("no step can be solved").to_string();
        assert!(
            told.contains("attempts") && !told.contains("raise --budget"),
            "{told}"
        );
    }

    #[test]
    fn what_an_answer_takes_is_set_aside() {
        let scene = scene(CALM);
        let mut watch = |_: StudyNews| true;
        let runs = runs(&scene, 14000.0, &mut watch);
        let (own, reference) = runs.missing();
        let (own, reference) = (own.expect("not made"), reference.expect("one of several"));
        let other = Discretisation { cells: 12, ..own };
        let close = |a: f64, b: f64| (a - b).abs() < 60.0;
        // The half of the budget, but for the run on the scene's mesh; that one leaves the reference its time.
        assert!(close(runs.room(&other), 0.5 * 14000.0 - 1000.0));
        assert!(close(runs.room(&own), 14000.0 - runs.price(&reference)));
    }

    #[test]
    fn a_recommended_budget_has_two_digits() {
        for (seconds, rounded) in [
            (0.2, 1.0),
            (7.1, 8.0),
            (61.0, 61.0),
            (101.0, 110.0),
            (2683.0, 2700.0),
        ] {
            assert_eq!(round_up(seconds), rounded);
        }
    }
}
