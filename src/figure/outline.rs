//! The segments of a contour as curves.

use crate::fem::Contour;
use std::collections::HashMap;

/// Ends of segments that are as near as this are one point, in parts of the greatest coordinate.
const NEAR: f64 = 1e-7;

/// The zero set's segments, chained to curves: closed ones end where they begin.
///
/// Neighbouring triangles give the same end of a segment, up to rounding.
pub(super) fn chain(contour: &Contour) -> Vec<Vec<[f64; 2]>> {
    let coordinates = contour.segments.iter().flatten().flatten();
    let greatest = coordinates.fold(0.0_f64, |greatest, at| greatest.max(at.abs()));
    let mut ends = Ends {
        near: NEAR * greatest,
        ..Ends::default()
    };
    let segments: Vec<[usize; 2]> = contour
        .segments
        .iter()
        .map(|segment| segment.map(|end| ends.number(end)))
        .filter(|[from, to]| from != to)
        .collect();
    // A segment has φ > 0 on its left, so the next one begins where it ends.
    let mut leaving: HashMap<usize, Vec<usize>> = HashMap::new();
    let mut arrivals = vec![0_u32; ends.places.len()];
    for (number, [from, to]) in segments.iter().enumerate() {
        leaving.entry(*from).or_default().push(number);
        arrivals[*to] += 1;
    }
    let mut used = vec![false; segments.len()];
    let mut curves = Vec::new();
    // First the curves that begin at the wall, where nothing arrives; then the closed ones.
    let (open, closed): (Vec<usize>, Vec<usize>) =
        (0..segments.len()).partition(|&number| arrivals[segments[number][0]] == 0);
    for first in open.into_iter().chain(closed) {
        let mut next = Some(first).filter(|&number| !used[number]);
        let mut curve = Vec::new();
        while let Some(number) = next {
            used[number] = true;
            let [from, to] = segments[number];
            if curve.is_empty() {
                curve.push(ends.places[from]);
            }
            curve.push(ends.places[to]);
            next = leaving.get_mut(&to).and_then(|candidates| {
                candidates.retain(|&candidate| !used[candidate]);
                candidates.pop()
            });
        }
        if !curve.is_empty() {
            curves.push(curve);
        }
    }
    curves
}

/// Points, those that are near each other with one number.
#[derive(Default)]
struct Ends {
    near: f64,
    places: Vec<[f64; 2]>,
    by_cell: HashMap<[i64; 2], usize>,
}

impl Ends {
    fn number(&mut self, place: [f64; 2]) -> usize {
        let cell = place.map(|coordinate| (coordinate / self.near).round() as i64);
        for dx in -1..=1 {
            for dy in -1..=1 {
                if let Some(&number) = self.by_cell.get(&[cell[0] + dx, cell[1] + dy]) {
                    return number;
                }
            }
        }
        self.places.push(place);
        self.by_cell.insert(cell, self.places.len() - 1);
        self.places.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Mesh;
    use std::f64::consts::PI;

    fn length(curve: &[[f64; 2]]) -> f64 {
        let piece = |pair: &[[f64; 2]]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        curve.windows(2).map(piece).sum()
    }

    fn curves(cells: usize, phi: impl Fn(f64, f64) -> f64) -> Vec<Vec<[f64; 2]>> {
        let mesh = Mesh::structured(cells, 0.0, 1).expect("a fair mesh");
        let values: Vec<f64> = mesh.nodes().iter().map(|&[x, y]| phi(x, y)).collect();
        chain(&Contour::new(&mesh, &values))
    }

    #[test]
    fn a_circle_is_one_closed_curve_of_its_length() {
        let radius = 0.3;
        let circle = |x: f64, y: f64| radius - (x - 0.5).hypot(y - 0.5);
        let error = |cells| {
            let curves = curves(cells, circle);
            assert_eq!(curves.len(), 1);
            assert_eq!(curves[0].first(), curves[0].last());
            (length(&curves[0]) / (2.0 * PI * radius) - 1.0).abs()
        };
        // Of order h²; chords are too short.
        assert!(error(50) < 1e-3, "{}", error(50));
        assert!(error(100) < error(50) / 3.0);
    }

    #[test]
    fn the_membrane_of_a_domain_in_metres_is_one_curve_too() {
        let mesh = Mesh::structured(40, 0.0, 1).expect("a fair mesh");
        let circle = |&[x, y]: &[f64; 2]| 0.3 - (x - 0.5).hypot(y - 0.5);
        let values: Vec<f64> = mesh.nodes().iter().map(circle).collect();
        let mut contour = Contour::new(&mesh, &values);
        let whole = chain(&contour);
        let ends = contour.segments.iter_mut().flatten().flatten();
        ends.for_each(|coordinate| *coordinate *= 1e-6);
        let small = chain(&contour);
        assert_eq!(small.len(), 1);
        assert_eq!(small[0].len(), whole[0].len());
    }

    #[test]
    fn two_vesicles_are_two_curves_and_one_at_the_wall_is_open() {
        let two = |x: f64, y: f64| {
            let distance = |cx: f64| 0.15 - (x - cx).hypot(y - 0.5);
            distance(0.25).max(distance(0.75))
        };
        assert_eq!(curves(40, two).len(), 2);
        let half = curves(40, |x, _| 0.3 - x);
        assert_eq!(half.len(), 1);
        assert!((length(&half[0]) - 1.0).abs() < 1e-12);
        assert_ne!(half[0].first(), half[0].last());
    }

    #[test]
    fn a_contour_through_nodes_is_one_curve() {
        // φ is exactly 0 at a row of nodes.
        let flat = curves(10, |_, y| 0.5 - y);
        assert_eq!(flat.len(), 1, "{flat:?}");
        assert!((length(&flat[0]) - 1.0).abs() < 1e-12);
        assert!(curves(10, |_, _| -1.0).is_empty());
    }
}
