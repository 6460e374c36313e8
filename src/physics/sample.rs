//! A state of the fields as the effects see it: at the quadrature points and on the triangles.

use crate::fem::Space;

/// φ, ω and d, sampled. Refilled in place, never reallocated.
#[derive(Debug, Clone)]
pub struct Sample {
    /// φ at the points.
    pub phi: Vec<f64>,
    /// ω at the points.
    pub omega: Vec<f64>,
    /// ∇φ on the triangles.
    pub phi_gradient: Vec<[f64; 2]>,
    /// ∇ω on the triangles.
    pub omega_gradient: Vec<[f64; 2]>,
    /// d, if the scene has a director.
    pub director: Option<DirectorSample>,
}

/// d, sampled: component by component.
#[derive(Debug, Clone)]
pub struct DirectorSample {
    /// d_x and d_y at the nodes.
    pub nodal: [Vec<f64>; 2],
    /// d_x and d_y at the points.
    pub values: [Vec<f64>; 2],
    /// ∇d_x and ∇d_y on the triangles.
    pub gradients: [Vec<[f64; 2]>; 2],
}

impl Sample {
    /// Zero fields on a space.
    pub fn new(space: &Space, with_director: bool) -> Self {
        let points = || vec![0.0; space.points()];
        let gradients = || vec![[0.0; 2]; space.elements()];
        Self {
            phi: points(),
            omega: points(),
            phi_gradient: gradients(),
            omega_gradient: gradients(),
            director: with_director.then(|| DirectorSample {
                nodal: [vec![0.0; space.nodes()], vec![0.0; space.nodes()]],
                values: [points(), points()],
                gradients: [gradients(), gradients()],
            }),
        }
    }

    /// Samples nodal values of φ.
    pub fn set_phi(&mut self, space: &Space, phi: &[f64]) {
        space.interpolate(phi, &mut self.phi);
        space.gradient(phi, &mut self.phi_gradient);
    }

    /// Samples nodal values of ω.
    pub fn set_omega(&mut self, space: &Space, omega: &[f64]) {
        space.interpolate(omega, &mut self.omega);
        space.gradient(omega, &mut self.omega_gradient);
    }

    /// Samples nodal values of d, where the sample has a director.
    pub fn set_director(&mut self, space: &Space, director: &[Vec<f64>; 2]) {
        if let Some(sample) = &mut self.director {
            for (axis, component) in director.iter().enumerate() {
                sample.nodal[axis].copy_from_slice(component);
                space.interpolate(component, &mut sample.values[axis]);
                space.gradient(component, &mut sample.gradients[axis]);
            }
        }
    }
}
