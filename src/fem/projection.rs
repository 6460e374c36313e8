//! Bringing a given function onto the P1 space. Always by the seven-point rule and the consistent
//! mass matrix, whatever the quadrature of the run.

use std::sync::Arc;

use super::{FemError, MassForm, Mesh, QuadratureRule, Space};
use crate::geometry::{Point, Vector};
use crate::linalg::{ConjugateGradients, LinearOperator, SparseMatrix, vector};

/// Relative residual to which the systems of the projections are solved: rounding, with a margin.
const TOLERANCE: f64 = 1e-13;

/// A function on Ω with its gradient.
pub trait GivenFunction {
    /// The value and the gradient at a place.
    fn at(&self, place: Point) -> (f64, Vector);
}

impl<F: Fn(Point) -> (f64, Vector)> GivenFunction for F {
    fn at(&self, place: Point) -> (f64, Vector) {
        self(place)
    }
}

/// The L2 projection (3.15): (u_h, v) = (u, v) for all v; with `wall`, u_h has that value on ∂Ω and
/// v vanishes there.
///
/// # Errors
/// `Projection` when the linear system could not be solved.
pub fn l2_projection(
    mesh: &Arc<Mesh>,
    given: &impl GivenFunction,
    wall: Option<f64>,
) -> Result<Vec<f64>, FemError> {
    let space = Space::new(mesh.clone(), QuadratureRule::Consistent);
    let mut load = vec![0.0; space.nodes()];
    let no_flux = vec![Vector::zeros(); space.elements()];
    space.add_load(&values_at_points(&space, given), &no_flux, &mut load);
    let matrix = sparse(space.mass());
    solve(&space, matrix, load, wall)
}

/// The Ritz projection: (∇u_h, ∇v) = (∇u, ∇v) for all v, with ∫u_h = ∫u; with `wall`, u_h has that
/// value on ∂Ω, v vanishes there, and the mean is what comes out.
///
/// # Errors
/// `Projection` when the linear system could not be solved.
pub fn ritz_projection(
    mesh: &Arc<Mesh>,
    given: &impl GivenFunction,
    wall: Option<f64>,
) -> Result<Vec<f64>, FemError> {
    let space = Space::new(mesh.clone(), QuadratureRule::Consistent);
    let mut load = vec![0.0; space.nodes()];
    let no_density = vec![0.0; space.points()];
    space.add_load(&no_density, &mean_gradients(&space, given), &mut load);
    let mut projected = solve(&space, space.stiffness(), load, wall)?;
    if wall.is_none() {
        let wanted = space.whole().integrate(&values_at_points(&space, given));
        let domain: f64 = mesh.measures().iter().sum();
        let shift = (wanted - space.integrate_nodal(&projected)) / domain;
        projected.iter_mut().for_each(|value| *value += shift);
    }
    Ok(projected)
}

/// φ with (∇φ, ∇v) = ⟨load, v⟩ for all v and ∫φ = `integral`, to rounding; the mean of the load is taken off first. With
/// `wall`, φ has that value on ∂Ω and v vanishes there; the load gets the multiple of (1, v) with which the integral is
/// that. `guess` is something near φ.
///
/// # Errors
/// `Projection` when the linear system could not be solved.
pub fn solve_poisson(
    space: &Space,
    mut load: Vec<f64>,
    integral: f64,
    wall: Option<f64>,
    guess: &[f64],
) -> Result<Vec<f64>, FemError> {
    let weights = space.nodal_weights();
    let domain: f64 = weights.iter().sum();
    let mean = load.iter().sum::<f64>() / domain;
    vector::add_scaled(&mut load, -mean, weights);
    let stiffness = space.stiffness();
    let mut phi = solve_from(space, stiffness, load, wall, guess.to_vec())?;
    let missing = integral - space.integrate_nodal(&phi);
    if wall.is_none() {
        phi.iter_mut().for_each(|value| *value += missing / domain);
    } else {
        let bump = solve(space, stiffness, weights.to_vec(), Some(0.0))?;
        let scale = missing / space.integrate_nodal(&bump);
        vector::add_scaled(&mut phi, scale, &bump);
    }
    Ok(phi)
}

/// The function at the seven points of every triangle.
fn values_at_points(space: &Space, given: &impl GivenFunction) -> Vec<f64> {
    space.sample(|place| given.at(place).0)
}

/// The mean of the function's gradient over every triangle: all that a P1 test function sees.
fn mean_gradients(space: &Space, given: &impl GivenFunction) -> Vec<Vector> {
    let (along_x, along_y): (Vec<f64>, Vec<f64>) = space
        .point_positions()
        .into_iter()
        .map(|place| given.at(place).1)
        .map(|gradient| (gradient.x, gradient.y))
        .unzip();
    let [x, y] = [along_x, along_y].map(|component| {
        let mut means = vec![0.0; space.elements()];
        space.whole().element_means(&component, &mut means);
        means
    });
    x.iter().zip(y).map(|(x, y)| Vector::new(*x, y)).collect()
}

fn sparse(form: &MassForm) -> &SparseMatrix {
    match form {
        MassForm::Sparse(matrix) => matrix,
        MassForm::Nodal(_) => unreachable!("the consistent rule makes sparse forms"),
    }
}

/// A matrix restricted to the unknown nodes.
struct Restricted<'a> {
    matrix: &'a SparseMatrix,
    known: Vec<bool>,
}

impl LinearOperator for Restricted<'_> {
    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        self.matrix.multiply(x, y);
        for (y, known) in y.iter_mut().zip(&self.known) {
            if *known {
                *y = 0.0;
            }
        }
    }
}

/// Solves A u = load, with u = `wall` on ∂Ω if that is given.
fn solve(
    space: &Space,
    matrix: &SparseMatrix,
    load: Vec<f64>,
    wall: Option<f64>,
) -> Result<Vec<f64>, FemError> {
    let guess = vec![0.0; space.nodes()];
    solve_from(space, matrix, load, wall, guess)
}

/// The same from a guess.
fn solve_from(
    space: &Space,
    matrix: &SparseMatrix,
    mut load: Vec<f64>,
    wall: Option<f64>,
    mut unknown: Vec<f64>,
) -> Result<Vec<f64>, FemError> {
    let size = space.nodes();
    let known: Vec<bool> = space
        .mesh()
        .on_boundary()
        .iter()
        .map(|on| *on && wall.is_some())
        .collect();
    let mut lift = vec![0.0; size];
    for (lift, known) in lift.iter_mut().zip(&known) {
        if *known {
            *lift = wall.unwrap_or_default();
        }
    }
    matrix.multiply_add(-1.0, &lift, &mut load);
    for (load, known) in load.iter_mut().zip(&known) {
        if *known {
            *load = 0.0;
        }
    }
    let inverse_diagonal: Vec<f64> = matrix.diagonal().iter().map(|d| d.recip()).collect();
    for (unknown, known) in unknown.iter_mut().zip(&known) {
        if *known {
            *unknown = 0.0;
        }
    }
    // A singular stiffness matrix is no obstacle: its load is orthogonal to the constants.
    ConjugateGradients::new(size).solve(
        &mut Restricted { matrix, known },
        &inverse_diagonal,
        &load,
        &mut unknown,
        TOLERANCE,
        10 * size,
    )?;
    Ok(unknown
        .iter()
        .zip(&lift)
        .map(|(u, lift)| u + lift)
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> Arc<Mesh> {
        Arc::new(Mesh::structured(12, 0.2, 5).expect("a fair mesh"))
    }

    fn linear(at: Point) -> (f64, Vector) {
        (1.5 * at.x - 0.25 * at.y + 3.0, Vector::new(1.5, -0.25))
    }

    #[test]
    fn both_projections_reproduce_the_space() {
        let mesh = mesh();
        let exact: Vec<f64> = mesh.nodes().iter().map(|&node| linear(node).0).collect();
        for projected in [
            l2_projection(&mesh, &linear, None).expect("solvable"),
            ritz_projection(&mesh, &linear, None).expect("solvable"),
        ] {
            let worst = projected
                .iter()
                .zip(&exact)
                .map(|(p, e)| (p - e).abs())
                .fold(0.0, f64::max);
            assert!(worst < 1e-11, "{worst}");
        }
    }

    #[test]
    fn a_wall_value_is_taken_exactly_and_the_rest_is_orthogonal() {
        let mesh = mesh();
        let bump = |at: Point| {
            let [p, q] = [at.x, at.y].map(|x| x * (1.0 - x));
            let gradient = Vector::new((1.0 - 2.0 * at.x) * q, p * (1.0 - 2.0 * at.y));
            (p * q - 1.0, gradient)
        };
        let projected = ritz_projection(&mesh, &bump, Some(-1.0)).expect("solvable");
        let space = Space::new(mesh.clone(), QuadratureRule::Consistent);
        let mut residual = vec![0.0; space.nodes()];
        space.stiffness().multiply(&projected, &mut residual);
        let mut load = vec![0.0; space.nodes()];
        let no_density = vec![0.0; space.points()];
        space.add_load(&no_density, &mean_gradients(&space, &bump), &mut load);
        for ((node, on), value) in mesh.on_boundary().iter().enumerate().zip(&projected) {
            if *on {
                assert_eq!(*value, -1.0);
            } else {
                assert!((residual[node] - load[node]).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn ritz_keeps_the_mean() {
        let mesh = mesh();
        let wave = |at: Point| {
            let (sine, cosine) = (5.0 * at.x).sin_cos();
            (sine * at.y, Vector::new(5.0 * cosine * at.y, sine))
        };
        let projected = ritz_projection(&mesh, &wave, None).expect("solvable");
        let space = Space::new(mesh.clone(), QuadratureRule::Consistent);
        let wanted = space.whole().integrate(&values_at_points(&space, &wave));
        assert!((space.integrate_nodal(&projected) - wanted).abs() < 1e-15);
    }
}
