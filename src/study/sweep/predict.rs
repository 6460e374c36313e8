//! What the points of a sweep will take: measured for a few, by size for the others.

use super::error::SweepError;
use super::folder::Sweep;
use super::points::Needs;
use crate::study::{Foresight, run_estimate};

/// So many points are tried at most: the smallest, the largest and one between.
const TRIED: usize = 3;

/// What each point will take: the first steps of up to three points are made, each for some seconds; the seconds of the
/// others follow by their sizes. `go_on` is asked meanwhile.
///
/// # Errors
/// [`SweepError::Plan`]: a file that a scene needs has changed.
pub fn predict(sweep: &Sweep, go_on: &mut dyn FnMut() -> bool) -> Result<Vec<Needs>, SweepError> {
    let mut needs = sweep.needs.clone();
    let mut by_work: Vec<usize> = (0..needs.len()).collect();
    by_work.sort_by(|a, b| needs[*a].work.total_cmp(&needs[*b].work));
    let mut tried: Vec<usize> = (0..TRIED)
        .filter_map(|part| by_work.get(part * by_work.len().saturating_sub(1) / (TRIED - 1)))
        .copied()
        .collect();
    tried.dedup();
    let mut known: Vec<(f64, f64)> = Vec::new();
    for number in tried {
        let scene = sweep.scene(&sweep.points[number])?;
        // A point that fails here is reported when it is run.
        if let Ok(Foresight::Price(price)) = run_estimate(&scene, go_on) {
            known.push((needs[number].work, price.seconds));
        }
    }
    for needs in &mut needs {
        needs.seconds = seconds(&known, needs.work);
    }
    Ok(needs)
}

/// The seconds for so much work: between the tried points by a power of the work, beyond them in proportion to it.
fn seconds(known: &[(f64, f64)], work: f64) -> Option<f64> {
    let same: Vec<f64> = known
        .iter()
        .filter(|(other, _)| *other == work)
        .map(|(_, seconds)| *seconds)
        .collect();
    if !same.is_empty() {
        return Some(same.iter().sum::<f64>() / same.len() as f64);
    }
    let below = known.iter().rfind(|(other, _)| *other < work);
    let above = known.iter().find(|(other, _)| *other > work);
    match (below, above) {
        (Some((w0, s0)), Some((w1, s1))) => {
            let share = (work / w0).ln() / (w1 / w0).ln();
            Some(s0 * (s1 / s0).powf(share))
        }
        (Some((other, seconds)), None) | (None, Some((other, seconds))) => {
            Some(seconds * work / other)
        }
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::seconds;

    #[test]
    fn between_by_a_power_and_beyond_in_proportion() {
        let known = [(10.0, 1.0), (1000.0, 100.0)];
        let at = |work| seconds(&known, work).expect("known");
        assert!((at(100.0) - 10.0).abs() < 1e-12);
        assert!((at(5.0) - 0.5).abs() < 1e-12 && (at(2000.0) - 200.0).abs() < 1e-9);
        assert_eq!(seconds(&[(10.0, 1.0), (10.0, 3.0)], 10.0), Some(2.0));
        assert_eq!(seconds(&[], 10.0), None);
    }
}
