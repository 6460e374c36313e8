//! A state of the fields as the effects see it: on one patch, at the quadrature points and on the
//! triangles.

use crate::fem::{Patch, Space};
use crate::geometry::Vector;
use crate::scene::ScalarField;

/// φ, ω and d on a patch. Refilled in place: once it has seen the largest patch, nothing is allocated.
#[derive(Debug, Clone, Default)]
pub struct PatchFields {
    /// φ at the points.
    pub phi: Vec<f64>,
    /// ω at the points.
    pub omega: Vec<f64>,
    /// ∇φ on the triangles.
    pub phi_gradient: Vec<Vector>,
    /// ∇ω on the triangles.
    pub omega_gradient: Vec<Vector>,
    /// d, if the scene has a director.
    pub director: Option<DirectorFields>,
}

/// d on a patch: component by component.
#[derive(Debug, Clone, Default)]
pub struct DirectorFields {
    /// d_x and d_y at the points.
    pub values: [Vec<f64>; 2],
    /// ∇d_x and ∇d_y on the triangles.
    pub gradients: [Vec<Vector>; 2],
    /// By rotation the component of ∇d along the circle, d_r/r on the triangles; empty in the plane.
    pub hoop: Vec<f64>,
}

impl DirectorFields {
    /// d at a point.
    pub fn at(&self, point: usize) -> Vector {
        Vector::new(self.values[0][point], self.values[1][point])
    }

    /// d at the points.
    pub fn vectors(&self) -> impl Iterator<Item = Vector> {
        let [x, y] = &self.values;
        x.iter().zip(y).map(|(x, y)| Vector::new(*x, *y))
    }
}

impl PatchFields {
    /// Of fields that are not known yet.
    pub fn new(with_director: bool) -> Self {
        Self {
            director: with_director.then(DirectorFields::default),
            ..Self::default()
        }
    }

    /// To be called before the fields of another patch are sampled. Where debug assertions are on, as
    /// in tests, what is not sampled then is empty; elsewhere emptying it would cost a tenth of a step.
    pub fn begin(&mut self) {
        if !cfg!(debug_assertions) {
            return;
        }
        self.phi.clear();
        self.omega.clear();
        self.phi_gradient.clear();
        self.omega_gradient.clear();
        if let Some(director) = &mut self.director {
            director.values.iter_mut().for_each(Vec::clear);
            director.gradients.iter_mut().for_each(Vec::clear);
            director.hoop.clear();
        }
    }

    /// Samples nodal values of φ.
    pub fn set_phi(&mut self, patch: &Patch<'_>, phi: &[f64]) {
        fill(patch, phi, &mut self.phi, &mut self.phi_gradient);
    }

    /// Samples nodal values of ω.
    pub fn set_omega(&mut self, patch: &Patch<'_>, omega: &[f64]) {
        fill(patch, omega, &mut self.omega, &mut self.omega_gradient);
    }

    /// Samples nodal values of d, where the sample has a director.
    pub fn set_director(&mut self, patch: &Patch<'_>, director: &[Vec<f64>; 2]) {
        if let Some(sample) = &mut self.director {
            for (axis, component) in director.iter().enumerate() {
                let (values, gradients) = (&mut sample.values[axis], &mut sample.gradients[axis]);
                fill(patch, component, values, gradients);
            }
            patch.hoop_gradient(&director[0], &mut sample.hoop);
        }
    }
}

/// A given function at the points: a formula is taken there, nodal values are interpolated.
pub(super) fn at_points(field: &ScalarField, space: &Space) -> Vec<f64> {
    match field {
        ScalarField::Constant(value) => vec![*value; space.points()],
        ScalarField::Expression(formula) => space.sample(|at| formula.evaluate(at.x, at.y)),
        ScalarField::File(file) => {
            let mut values = vec![0.0; space.points()];
            let nodal = space.mesh().inward(file.values.to_vec());
            space.whole().interpolate(&nodal, &mut values);
            values
        }
    }
}

fn fill(patch: &Patch<'_>, nodal: &[f64], points: &mut Vec<f64>, gradients: &mut Vec<Vector>) {
    points.resize(patch.points(), 0.0);
    gradients.resize(patch.elements(), Vector::zeros());
    patch.sample(nodal, points, gradients);
}
