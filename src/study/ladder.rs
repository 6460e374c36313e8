//! The runs of a study, within a budget.
//!
//! A ladder of meshes (a quarter, a half and the whole of the scene's cells) and tolerances, the
//! scene's own choice, another quadrature and another iteration. The cheapest run comes first; from
//! what it took the others' prices are estimated. An answer takes a run on the scene's own mesh and a
//! reference on a finer one: what they take is set aside, and where the budget does not pay for them the
//! study ends at once and names one that does; before that, the first steps on the scene's mesh are tried. Of the others a run that would not fit into what is left
//! of the budget is left out; half of the budget is for the reference, the finest mesh that it pays for.
//! A run that fails, or is stopped, stays in the study and says so.

use super::choice::{Choice, fixed_mesh};
use super::evaluation::evaluate;
use super::finished::FinishedRuns;
use super::measure::{Failure, Measurement, measure};
use super::plan::{Known, known, ladder, own_mesh, price, references};
use super::price::{Foresight, run_price};
use super::report::Study;
use crate::scene::Scene;
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

/// Why there is no study.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StudyError {
    /// Not even the cheapest run came to its end.
    #[error("not even the cheapest run ({cells} cells, {pace}) came to its end: {reason}")]
    Nothing {
        /// 1/h.
        cells: usize,
        /// How long its steps were.
        pace: String,
        /// Why.
        reason: String,
    },
    /// The budget does not pay for an answer.
    #[error(
        "a budget of {budget:.0} s is too little: a run with {own} and a reference with {reference} take \
         about {price:.0} s, and {left:.0} s are left; give --budget {enough:.0}, or a coarser mesh"
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
        /// With how much there is an answer, with a good reference.
        enough: f64,
    },
    /// Whoever watches has ended it.
    #[error("the study was ended before its first run was done")]
    Ended,
}

/// An estimate of a run's price may be too low by this before the run is stopped.
const PATIENCE: f64 = 2.0;

/// The share of the budget that the reference may take.
const REFERENCE_SHARE: f64 = 0.5;

/// A run that takes a smaller share of the budget than this is made before it is known whether the budget
/// is enough: it makes the estimates better.
const EASY: f64 = 0.05;

/// A budget that is recommended is so many times what the runs are expected to take.
const MARGIN: f64 = 1.3;

/// Makes the runs of a study, and puts those beside them that are finished. `watch` is told which run is
/// under way and how far it is (0 to 1), and says whether to go on; without it the study ends with what
/// there is.
///
/// # Errors
/// [`StudyError`]: there is nothing to report.
pub fn study(
    scene: &Scene,
    budget: Budget,
    finished: FinishedRuns,
    watch: &mut dyn FnMut(&Choice, f64) -> bool,
) -> Result<Study, StudyError> {
    let own = Choice::of(scene);
    let is_own_there = finished.beside.iter().any(|run| run.is_own);
    let mut rest = ladder(scene, budget.full);
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
        foreseen: None,
        watch,
        ended: false,
    };
    let is_enough = finished.against.is_some() && !finished.beside.is_empty();
    let mut is_checked = is_enough;
    let mut made = 0;
    while !runs.ended {
        // The cheap ones first, so that prices are known better and better. The first in the list is the
        // cheapest as long as nothing is known.
        rest.sort_by(|a, b| runs.price(a).total_cmp(&runs.price(b)));
        let is_easy = |choice: &Choice| runs.price(choice) <= EASY * budget.time.as_secs_f64();
        if made > 0 && !is_checked && !rest.first().is_some_and(is_easy) {
            is_checked = true;
            if runs.check_budget().is_err() {
                runs.foresee();
                if runs.ended {
                    break;
                }
                runs.check_budget()?;
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
        match &runs.done[0].1.outcome {
            Ok(_) => {}
            Err(_) if is_enough => {}
            Err(Failure::Ended) => return Err(StudyError::Ended),
            Err(reason) => return Err(runs.nothing(reason)),
        }
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
    own_mesh: Option<Choice>,
    /// What the others may be measured against, the most accurate first.
    references: Vec<Choice>,
    done: Vec<(Choice, Measurement)>,
    /// What the run on the scene's mesh is expected to take, by its first steps.
    foreseen: Option<Known>,
    watch: &'a mut dyn FnMut(&Choice, f64) -> bool,
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

    fn price(&self, choice: &Choice) -> f64 {
        let known = self.done.iter().filter_map(known).chain(self.foreseen);
        price(self.scene, choice, known)
    }

    /// Makes the first steps of the run on the scene's mesh: they tell more than runs on meshes that may be
    /// too coarse for the scene.
    fn foresee(&mut self) {
        let (Some(choice), _) = self.missing() else {
            return;
        };
        let seconds = self.left(1.0);
        let (begun, watch, mut is_ended) = (Instant::now(), &mut *self.watch, false);
        let mut go_on = || {
            is_ended |= !watch(&choice, 0.0);
            !is_ended && begun.elapsed().as_secs_f64() < seconds
        };
        let price = run_price(&choice.applied_to(self.scene), &mut go_on);
        self.ended |= is_ended;
        if let Ok(Foresight::Price(price)) = price {
            self.foreseen = Some((choice, price.seconds));
        }
    }

    /// Which runs there must be still, and what they take: that on the scene's mesh, and a reference.
    fn missing(&self) -> (Option<Choice>, Option<Choice>) {
        let is_made = |wanted: &Choice| self.done.iter().any(|(choice, _)| choice == wanted);
        let cheapest = self.references.iter();
        let cheapest = cheapest.min_by(|a, b| self.price(a).total_cmp(&self.price(b)));
        (self.own_mesh.filter(|own| !is_made(own)), cheapest.copied())
    }

    /// How long a run may take, so that there is time for those that there must be.
    fn room(&self, next: &Choice) -> f64 {
        let (own_mesh, reference) = self.missing();
        let price = |choice: Option<Choice>| choice.map_or(0.0, |choice| self.price(&choice));
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
        let finest = self.references.first().map(|choice| choice.cells);
        let good = self
            .references
            .iter()
            .filter(|choice| Some(choice.cells) == finest);
        let good = good
            .map(|choice| self.price(choice))
            .fold(f64::INFINITY, f64::min);
        let good = if good.is_finite() { good } else { 0.0 };
        let words =
            |choice: Option<Choice>| choice.map_or("what there is".to_owned(), |it| it.to_string());
        Err(StudyError::Budget {
            budget: self.budget.time.as_secs_f64(),
            own: words(own_mesh.or(self.own_mesh)),
            reference: words(reference),
            price,
            left: self.left(1.0).max(0.0),
            enough: round_up(MARGIN * (self.begun.elapsed().as_secs_f64() + own_price + good)),
        })
    }

    /// Why there is nothing to report where the first run failed.
    fn nothing(&self, reason: &Failure) -> StudyError {
        if let (Failure::TooLong, Err(error)) = (reason, self.check_budget()) {
            return error;
        }
        let (first, measured) = &self.done[0];
        StudyError::Nothing {
            cells: first.cells,
            pace: first.pace.to_string(),
            reason: match reason {
                Failure::Failed(reason) => reason.clone(),
                _ => format!(
                    "it was stopped after {:.0} s; raise --budget",
                    measured.seconds
                ),
            },
        }
    }

    /// That the scene's own steps were not run, and with which budget they are.
    fn without_own_steps(&self, own: &Choice) -> String {
        let price = self.price(own);
        let spent = self.begun.elapsed().as_secs_f64();
        let hint = match price.is_finite() && !self.ended {
            true => format!(
                ": they take about {price:.0} s, and a --budget of {:.0} has room for them",
                round_up(MARGIN * (spent + price) / self.share())
            ),
            false => String::new(),
        };
        format!("The scene's own choice, {own}, was not run{hint}.")
    }

    fn measure(&mut self, choice: &Choice, seconds: f64) -> Measurement {
        let limit = Duration::try_from_secs_f64(seconds).unwrap_or_default();
        let watch = &mut *self.watch;
        let measured = measure(self.scene, choice, limit, &mut |done| watch(choice, done));
        self.ended |= measured.outcome.as_ref().err() == Some(&Failure::Ended);
        measured
    }

    fn make(&mut self, choice: Choice, seconds: f64) {
        let measured = self.measure(&choice, seconds);
        self.done.push((choice, measured));
    }

    /// The most accurate run that the rest of the budget pays for.
    fn reference(&mut self) -> Option<(Choice, Measurement)> {
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
        watch: &'a mut dyn FnMut(&Choice, f64) -> bool,
    ) -> Runs<'a> {
        let own = own_mesh(&Choice::of(scene));
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
            foreseen: Some((own, 1000.0)),
            watch,
            ended: false,
        }
    }

    #[test]
    fn a_budget_without_an_answer_is_refused_with_one_that_has_it() {
        let scene = scene(CALM);
        let mut watch = |_: &Choice, _: f64| true;
        let error = runs(&scene, 3000.0, &mut watch).check_budget();
        let Err(StudyError::Budget { price, enough, .. }) = error else {
            panic!("{error:?}");
        };
        // With half as many cells again.
        let expected = 1000.0 * (1.0 + 1.5_f64.powf(2.6));
        assert!((price / expected - 1.0).abs() < 1e-9, "{price}");
        let told = error.expect_err("it is one").to_string();
        let words = [
            "3000 s is too little",
            "24 cells and tolerance 1e-3",
            "36 cells",
        ];
        for word in words.iter().chain(&[&*format!("--budget {enough:.0}")]) {
            assert!(told.contains(word), "{told}");
        }
        // A good reference, which has twice the cells, is paid for.
        let mut watch = |_: &Choice, _: f64| true;
        let runs = runs(&scene, enough, &mut watch);
        assert_eq!(runs.check_budget(), Ok(()));
        let finest = runs
            .references
            .iter()
            .find(|it| runs.price(it) < runs.left(1.0) - 1000.0);
        assert_eq!(finest.map(|it| it.cells), Some(48));
    }

    #[test]
    fn what_an_answer_takes_is_set_aside() {
        let scene = scene(CALM);
        let mut watch = |_: &Choice, _: f64| true;
        let runs = runs(&scene, 6000.0, &mut watch);
        let (own, reference) = runs.missing();
        let (own, reference) = (own.expect("not made"), reference.expect("one of several"));
        let other = Choice { cells: 12, ..own };
        let close = |a: f64, b: f64| (a - b).abs() < 60.0;
        // The half of the budget, but for the run on the scene's mesh; that one leaves the reference its time.
        assert!(close(runs.room(&other), 0.5 * 6000.0 - 1000.0));
        assert!(close(runs.room(&own), 6000.0 - runs.price(&reference)));
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
