//! How large the triangles of a generated mesh are to be, place by place.

use super::model::{Mesh, Refinement, Scene, Shape};
use super::outline::{OutlineDistance, union_distance};

/// By how much the size may grow over a unit of length: neighbours then differ by less than a third, and
/// the angles suffer little.
const GROWTH: f64 = 0.3;

/// Nodes of a generated mesh in a unit of area, times the square of the wanted length of an edge, as
/// counted at sizes from 0.02 to 0.004. (Of equilateral triangles it would be 2/√3.)
const DENSITY: f64 = 1.04;

/// The wanted length of an edge, as a function of the place.
#[derive(Debug)]
pub struct MeshSize {
    largest: f64,
    refined: Option<(Refinement, Vec<OutlineDistance>)>,
}

impl MeshSize {
    /// That of a scene; `None` where its mesh is not generated to a size.
    pub fn of(scene: &Scene) -> Option<Self> {
        let Mesh::Delaunay { size, refine, .. } = &scene.mesh else {
            return None;
        };
        let outlines = match &scene.vesicle.shape {
            Shape::Outlines(outlines) => outlines.iter().map(OutlineDistance::new).collect(),
            Shape::Random { .. } | Shape::File(_) => Vec::new(),
        };
        Some(Self {
            largest: *size,
            refined: refine.map(|refinement| (refinement, outlines)),
        })
    }

    /// The largest one.
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// The smallest one.
    pub fn smallest(&self) -> f64 {
        match &self.refined {
            Some((refinement, _)) => refinement.size,
            None => self.largest,
        }
    }

    /// At a place: within the band about the membrane the smaller one, from there on growing.
    pub fn at(&self, place: [f64; 2]) -> f64 {
        let Some((refinement, outlines)) = &self.refined else {
            return self.largest;
        };
        let distance = union_distance(outlines, place).value.abs();
        let beyond = (distance - refinement.band).max(0.0);
        (refinement.size + GROWTH * beyond).min(self.largest)
    }

    /// About how many nodes a mesh of the unit square has.
    pub fn nodes(&self) -> f64 {
        // Along the wall there are half as many more.
        let wall = 2.0 / self.largest;
        if self.refined.is_none() {
            return DENSITY / (self.largest * self.largest) + wall;
        }
        const SAMPLES: usize = 200;
        let at = |index: usize| (index as f64 + 0.5) / SAMPLES as f64;
        let places = (0..SAMPLES).flat_map(|row| (0..SAMPLES).map(move |column| [column, row]));
        let shares = places.map(|place| DENSITY / self.at(place.map(at)).powi(2));
        shares.sum::<f64>() / (SAMPLES * SAMPLES) as f64 + wall
    }
}
