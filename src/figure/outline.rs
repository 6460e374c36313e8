//! The segments of a contour as curves.

use crate::fem::Contour;
use std::collections::HashMap;

/// Ends of segments that are as near as this are one point, as a part of the curves' extent.
const NEAR: f64 = 1e-7;

/// The zero set's segments, chained to curves: closed ones end where they begin.
///
/// Neighbouring triangles give the same end of a segment, up to rounding.
pub(super) fn chain(contour: &Contour) -> Vec<Vec<[f64; 2]>> {
    let mut ends = Ends::around(contour);
    let segments: Vec<[usize; 2]> = contour
        .segments
        .iter()
        .map(|segment| segment.map(|end| ends.number(end.into())))
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
struct Ends {
    corner: [f64; 2],
    near: f64,
    places: Vec<[f64; 2]>,
    by_cell: HashMap<[i64; 2], usize>,
}

impl Ends {
    /// None yet of those of a contour.
    fn around(contour: &Contour) -> Self {
        let ranges = [0, 1].map(|axis| {
            let coordinates = contour.segments.iter().flatten().map(|place| place[axis]);
            coordinates.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
                [low.min(at), high.max(at)]
            })
        });
        let extent = ranges.map(|[low, high]| high - low);
        Self {
            corner: ranges.map(|[low, _]| low),
            near: NEAR * extent[0].max(extent[1]),
            places: Vec::new(),
            by_cell: HashMap::new(),
        }
    }

    fn number(&mut self, place: [f64; 2]) -> usize {
        let cell = [0, 1].map(|axis| {
            let offset = place[axis] - self.corner[axis];
            // The cast saturates.
            (offset / self.near).round() as i64
        });
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
    use crate::geometry::Point;
    use std::f64::consts::PI;

    fn length(curve: &[[f64; 2]]) -> f64 {
        let piece = |pair: &[[f64; 2]]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        curve.windows(2).map(piece).sum()
    }

    fn curves(cells: usize, phi: impl Fn(f64, f64) -> f64) -> Vec<Vec<[f64; 2]>> {
        let mesh = Mesh::structured(cells, 0.0, 1).expect("a fair mesh");
        let values: Vec<f64> = mesh.nodes().iter().map(|p| phi(p.x, p.y)).collect();
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

    /// The same whatever the domain's size.
    #[test]
    fn a_tiny_circle_and_a_huge_one_are_one_curve_too() {
        let unit = Mesh::structured(50, 0.0, 1).expect("a fair mesh");
        for size in [1e-9, 1e-5, 1e5, 1e13] {
            let nodes = unit.nodes().iter().map(|node| node.map(|it| size * it));
            let mesh = Mesh::new(nodes.collect(), unit.triangles().to_vec()).expect("fair too");
            let place = |node: &Point| node.map(|it| it / size - 0.5);
            let nodes = mesh.nodes().iter().map(place);
            let values: Vec<f64> = nodes.map(|p| 0.3 - p.x.hypot(p.y)).collect();
            let curves = chain(&Contour::new(&mesh, &values));
            assert_eq!(curves.len(), 1, "{size:e}");
            let ratio = length(&curves[0]) / (2.0 * PI * 0.3 * size);
            assert!((ratio - 1.0).abs() < 1e-2, "{size:e}: {ratio}");
        }
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
