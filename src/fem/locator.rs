//! In which triangle of a mesh a place lies.

use super::Mesh;
use super::raster::Place;
use crate::geometry::{BoundingBox, Point};

/// The triangles of a mesh, sorted into the cells of a grid over it: four cells a triangle, so that cells have few
/// triangles also where those are small.
#[derive(Debug)]
pub struct Locator<'a> {
    mesh: &'a Mesh,
    region: BoundingBox,
    /// Cells along each side.
    cells: usize,
    /// For each cell where its triangles begin in `members`; one more at the end.
    start: Vec<u32>,
    members: Vec<u32>,
}

impl<'a> Locator<'a> {
    /// Of a mesh.
    pub fn new(mesh: &'a Mesh) -> Self {
        let cells = (4.0 * mesh.triangles().len() as f64).sqrt().ceil() as usize;
        let mut locator = Self {
            mesh,
            region: mesh.bounding_box(),
            cells,
            start: vec![0; cells * cells + 1],
            members: Vec::new(),
        };
        for triangle in 0..mesh.triangles().len() {
            locator.each_cell(triangle, |start, cell| start[cell + 1] += 1);
        }
        for cell in 0..cells * cells {
            locator.start[cell + 1] += locator.start[cell];
        }
        let mut next = locator.start.clone();
        let mut members = vec![0; next[cells * cells] as usize];
        for triangle in 0..mesh.triangles().len() {
            locator.each_cell(triangle, |_, cell| {
                members[next[cell] as usize] = triangle as u32;
                next[cell] += 1;
            });
        }
        locator.members = members;
        locator
    }

    /// Calls `act` for the cells that the box around a triangle meets.
    fn each_cell(&mut self, triangle: usize, mut act: impl FnMut(&mut [u32], usize)) {
        let corners = self.mesh.triangles()[triangle];
        let hull = BoundingBox::around(corners.iter().map(|it| &self.mesh.nodes()[*it as usize]));
        let [first, last] = [hull.lower, hull.upper].map(|corner| self.cell(corner));
        for row in first[1]..=last[1] {
            for column in first[0]..=last[0] {
                act(&mut self.start, row * self.cells + column);
            }
        }
    }

    /// The column and the row of the cell of a place; of the nearest one, outside of them.
    fn cell(&self, place: Point) -> [usize; 2] {
        let extent = self.region.extent();
        [0, 1].map(|axis| {
            let share = (place[axis] - self.region.lower[axis]) / extent[axis];
            // The cast takes what is negative to 0.
            ((share * self.cells as f64) as usize).min(self.cells - 1)
        })
    }

    /// Where a place of the domain lies. For one that is outside of every triangle, be it by rounding, the nearest of
    /// those in its cell is taken and its functions are continued; `None` where there is none.
    pub fn find(&self, place: Point) -> Option<Place> {
        let [column, row] = self.cell(place);
        let cell = row * self.cells + column;
        let members = self.start[cell] as usize..self.start[cell + 1] as usize;
        let mut best: Option<(f64, Place)> = None;
        for &triangle in &self.members[members] {
            let nodes = self.mesh.triangles()[triangle as usize];
            let gradients = &self.mesh.gradients()[triangle as usize];
            let weights = [0, 1, 2].map(|corner| {
                let offset = place - self.mesh.nodes()[nodes[corner] as usize];
                1.0 + gradients[corner].dot(&offset)
            });
            let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
            if best.as_ref().is_none_or(|(other, _)| least > *other) {
                best = Some((least, Place { nodes, weights }));
            }
            if least >= 0.0 {
                break;
            }
        }
        best.map(|(_, place)| place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_is_found_and_linear_functions_are_reproduced() {
        let line = |at: Point| 2.0 * at.x - 3.0 * at.y + 0.5;
        for (cells, jitter) in [(1, 0.0), (7, 0.0), (31, 0.3)] {
            let mesh = Mesh::structured(cells, jitter, 5).expect("a fair mesh");
            let values: Vec<f64> = mesh.nodes().iter().map(|node| line(*node)).collect();
            let locator = Locator::new(&mesh);
            for n in 0..1000 {
                // With those on the wall, and at nodes.
                let place = Point::new(f64::from(n % 32) / 31.0, f64::from(n / 32) / 31.0);
                let found = locator.find(place).expect("in the square");
                assert!(found.weights.iter().all(|weight| *weight > -1e-12));
                assert!((found.value(&values) - line(place)).abs() < 1e-12);
            }
        }
    }
}
