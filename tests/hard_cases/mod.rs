//! Hard cases: scenes at and beyond the edge of what is sensible, each through a few steps, with what
//! must hold whatever the scene.
//!
//! Each is a scene file in `scenes/`, which `vesica run` takes as well. The quick part runs with all
//! tests. The long part makes at least ten times as many steps and writes the table of the worst
//! values, `tests/hard_cases/results.md`:
//!
//!     cargo test --release --test numerics -- hard_cases --ignored

mod cases;
mod oracle;

use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use self::cases::{CASES, Case};
use self::oracle::Worst;

/// Runs all cases, as many at once as there are processors, in their order; `how`: the number of steps, and a
/// setting.
fn run_all(how: fn(&Case) -> (u64, Option<&'static str>)) -> Vec<(&'static Case, Worst)> {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let workers = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        for _ in 0..workers {
            let (sender, next) = (sender.clone(), &next);
            scope.spawn(move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = CASES.get(index) else {
                        return;
                    };
                    let (steps, setting) = how(case);
                    let worst = oracle::run(case, steps, setting);
                    sender.send((index, case, worst)).expect("it is awaited");
                }
            });
        }
        drop(sender);
        let mut results: Vec<_> = receiver.iter().collect();
        results.sort_by_key(|(index, ..)| *index);
        results
            .into_iter()
            .map(|(_, case, worst)| (case, worst))
            .collect()
    })
}

/// What is broken, in words; empty when all is well.
fn complaints(results: &[(&Case, Worst)]) -> String {
    let mut text = String::new();
    for (case, worst) in results {
        for complaint in worst.complaints() {
            let _ = writeln!(text, "{}: {complaint}", case.name);
        }
    }
    text
}

#[test]
fn hard_cases_stay_stable() {
    // A step of this one takes a minute; with a weaker penalty (there is a case for the stronger one) a second.
    let results = run_all(|case| {
        let is_hardest = case.name == "random-9";
        (case.steps, is_hardest.then_some("area.penalty=1e-6"))
    });
    let complaints = complaints(&results);
    assert!(complaints.is_empty(), "{complaints}");
}

#[test]
#[ignore = "minutes; writes the table of results"]
fn hard_cases_stay_stable_for_long() {
    let results = run_all(|case| (case.long_steps, None));
    let mut table = String::from(
        "| case | steps | least Δt | law residual | least ND / S | rise of E / S | drift of ∫φ | turn by 180° | shift / h |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for (case, worst) in &results {
        let _ = writeln!(table, "| {} | {worst} |", case.name);
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hard_cases/results.md");
    std::fs::write(path, table).expect("the table can be written");
    let complaints = complaints(&results);
    assert!(complaints.is_empty(), "{complaints}");
}

/// The oracles see what they are to see: a step with a law that is not closed, an energy that rises, a
/// value that is not finite.
#[test]
fn the_oracles_can_fail() {
    let mut worst = Worst::default();
    assert!(worst.complaints().is_empty());
    worst.law_residual = 1.1e-8;
    assert_eq!(worst.complaints().len(), 1);
    worst.least_dissipation = Some(-1.1e-14);
    worst.rise = 1.1e-12;
    worst.drift = 1.1e-13;
    worst.asymmetry = Some(1e-3);
    worst.shift = Some(0.26);
    worst.failure = Some("a value that is not finite".into());
    assert_eq!(worst.complaints().len(), 7);
}
