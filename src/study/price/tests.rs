//! Prices: what is counted, and how it is told.

use super::chosen::Further;
use super::fixed::{Later, TimedStep, Work};
use super::*;
use crate::study::tests::{CALM, scene};

#[test]
fn what_a_run_still_takes_is_counted_from_where_it_stands() {
    let scene = scene(CALM);
    assert_eq!(
        coarse(&scene, LinearMethod::Automatic),
        None,
        "it is coarse itself"
    );
    let new = || Simulation::new(&scene).expect("a simulation");
    let mut whole = new();
    let mut steps = Vec::new();
    while whole.report().t < scene.time.end {
        let report = whole.advance().expect("a step");
        steps.push((report.t, f64::from(report.newton)));
    }
    let (from, _) = steps[2];
    let rest = &steps[3..];
    let all = Further::of(new(), from, Duration::MAX).expect("solved");
    assert_eq!(all.steps, rest.len() as f64);
    let corrections: f64 = rest.iter().map(|(_, newton)| newton).sum();
    assert_eq!(all.corrections, corrections);
    let begun = |steps: usize| {
        let mut simulation = new();
        for _ in 0..steps {
            simulation.advance().expect("a step");
        }
        simulation
    };
    let more = Further::of(begun(3), from, Duration::MAX).expect("solved");
    assert_eq!((more.steps, more.corrections), (all.steps, all.corrections));
    // Without time the rest is extrapolated.
    let cut = Further::of(begun(steps.len() / 2), from, Duration::ZERO).expect("solved");
    let left = (steps.len() - steps.len() / 2) as f64;
    assert!(
        cut.steps > 0.3 * left && cut.steps < 3.0 * left,
        "{cut:?} {left}"
    );
}

#[test]
fn seconds_are_told_to_two_digits() {
    let told = |seconds: f64| {
        let price = RunPrice {
            steps: 7,
            seconds,
            memory: 50_000_000,
        };
        price.to_string()
    };
    assert_eq!(told(0.34), "about 0.3 s and 50 MB, 7 steps");
    assert_eq!(told(1.43), "about 1.4 s and 50 MB, 7 steps");
    assert_eq!(told(11.6), "about 12 s and 50 MB, 7 steps");
    assert_eq!(told(900.0), "about 15 min and 50 MB, 7 steps");
}

#[test]
fn a_later_step_is_cheaper_by_the_work_that_it_does_not_do() {
    let work = |corrections, iterations| Work {
        corrections,
        iterations,
    };
    let step = TimedStep {
        seconds: 2.0,
        work: work(2.0, 20.0),
        // Half of the time on the clock was somebody else's; a fifth of it is for other parts.
        parts: [0.6, 0.6, 2.0, 4.0],
    };
    assert_eq!(step.seconds_with(work(2.0, 20.0)), 2.0);
    // A residual of three, a linearisation of two, and half of the iterations less.
    let wanted = 2.0 * (1.0 - (0.2 + 0.3 + 1.0) / 4.0);
    assert!((step.seconds_with(work(1.0, 10.0)) - wanted).abs() < 1e-12);
}

/// The coarse run solves as the scene does, or is not asked.
#[test]
fn later_steps_are_told_of_by_steps_that_are_solved_alike() {
    let finer = |settings: &str| {
        let mut scene = scene(&format!("time.step = 1e-7\n{settings}"));
        scene.mesh = Mesh::Structured {
            cells: 56,
            jitter: 0.0,
            seed: 1,
        };
        scene
    };
    let later = |scene: &Scene, method| Later::of(scene, 40, method).expect("solved");
    let fast = later(&finer(""), "transform");
    let factor = later(&finer(""), "factor");
    let work = |later: Later| later.work.expect("it can be told");
    assert!(!fast.with_factor && factor.with_factor);
    assert!(work(factor).iterations < work(fast).iterations);
    assert!(later(&finer(""), "shifted").work.is_some());
    // At a wall that is clamped there is the factor alone.
    let clamped = finer("domain.boundary = 'clamped'");
    assert_eq!(later(&clamped, "transform").work, None);
}
