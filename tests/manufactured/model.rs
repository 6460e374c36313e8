//! The continuous equations, written again from the energies: what an exact solution leaves over in
//! them is the source. Nothing here comes from the solver's own formulas.

use std::f64::consts::TAU;

use vesica::internal::scene::{AnchoringKind, Geometry, ScalarField};
use vesica::{Point, Scene, Vector};

use super::fields::{Director, DirectorField, Phase, PhaseField};

/// Something wrong with the source, for the negative controls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Flaw {
    /// The limit of G_sec as (3.24) prints it: 3(φ² − 1 − 2εkφ).
    PrintedSecant,
    /// δE_anch/δφ with the sign of (2.11).
    PrintedAnchoringSign,
    /// p̃ = (|d|² − 1) d/η_d² for long directors too.
    UntruncatedPenalty,
    /// A source that is ahead of its time by √Δt.
    HastyClock,
    /// By rotation ∇d without its part along the circle, d_r/r.
    NoHoop,
    /// A term that is 1 % too large.
    OnePercent(Term),
}

/// The terms of the equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Term {
    /// k in the second and third equation.
    Curvature,
    /// (B − β)/η.
    Tension,
    /// λ_nem i(φ)(½|∇d|² + P(d)) in substep 2.
    NematicPressure,
    /// The anchoring's flux in substep 2.
    AnchoringFlux,
    /// λ_nem I(φ) ∇d in substep 1.
    Elasticity,
    /// λ_nem I(φ) p̃ in substep 1.
    Penalty,
    /// The anchoring's torque in substep 1.
    AnchoringTorque,
    /// ∂d/∂t / γ_nem in substep 1.
    DirectorRate,
}

/// A vector to be tested with the gradient of a test function, and a value to be tested with it.
#[derive(Debug, Clone, Copy)]
pub struct WeakForm {
    /// Tested with ∇ψ.
    pub flux: Vector,
    /// Tested with ψ.
    pub load: f64,
}

/// The equations of a scene with an exact solution of them.
#[derive(Debug, Clone)]
pub struct Model {
    /// The parameters.
    pub scene: Scene,
    /// φ.
    pub phase: PhaseField,
    /// d.
    pub director: Option<DirectorField>,
    /// What is wrong.
    pub flaw: Option<Flaw>,
}

/// k(x, y) = 1.5 + x − 0.5 y, as a scene says it.
pub const CURVATURE: &str = "1.5 + x - 0.5*y";

/// ∇k.
const CURVATURE_GRADIENT: Vector = Vector::new(1.0, -0.5);

impl Model {
    fn factor(&self, term: Term) -> f64 {
        match self.flaw {
            Some(Flaw::OnePercent(flawed)) if flawed == term => 1.01,
            _ => 1.0,
        }
    }

    /// The time of the source of a step of length Δt that ends at t.
    pub fn source_time(&self, t: f64, dt: f64) -> f64 {
        match self.flaw {
            Some(Flaw::HastyClock) => t + dt.sqrt(),
            _ => t,
        }
    }

    /// k and ∇k.
    fn curvature(&self, place: Point) -> (f64, Vector) {
        let ScalarField::Expression(expression) = &self.scene.membrane.spontaneous_curvature else {
            panic!("the scenes of this test give k as a formula");
        };
        assert_eq!(expression.text(), CURVATURE);
        let factor = self.factor(Term::Curvature);
        (
            factor * (1.5 + place.x - 0.5 * place.y),
            factor * CURVATURE_GRADIENT,
        )
    }

    /// ω = −Δφ + G(φ)/ε² and ∇ω.
    pub fn omega(&self, place: Point, phase: &Phase) -> (f64, Vector) {
        let width = self.scene.membrane.interface_width;
        let (k, k_gradient) = self.curvature(place);
        let phi = phase.value;
        let well = phi * phi - 1.0;
        let value = -phase.laplacian + (phi * well - width * k * well) / (width * width);
        let slope = 3.0 * phi * phi - 1.0 - 2.0 * width * k * phi;
        let of_g = slope * phase.gradient - width * well * k_gradient;
        (value, of_g / (width * width) - phase.laplacian_gradient)
    }

    /// μ.
    pub fn mu(&self, phase: &Phase) -> f64 {
        phase.scaled_potential / self.scene.membrane.mobility
    }

    /// B of the exact φ: the midpoint rule is exact for cosines of fewer waves than twice its points. By rotation it is of second
    /// order along r, with far more points than a mesh has cells.
    fn surface_area(&self, t: f64) -> f64 {
        const POINTS: usize = 32;
        let columns = if self.is_rotated() { 256 } else { POINTS };
        let width = self.scene.membrane.interface_width;
        let coordinate = |index: usize, points: usize| (index as f64 + 0.5) / points as f64;
        let mut sum = 0.0;
        for i in 0..columns {
            let x = coordinate(i, columns);
            let weight = if self.is_rotated() { TAU * x } else { 1.0 };
            for j in 0..POINTS {
                let phase = self.phase.at(Point::new(x, coordinate(j, POINTS)), t);
                let well = phase.value * phase.value - 1.0;
                let gradient = phase.gradient.norm_squared();
                sum += weight * (0.5 * width * gradient + 0.25 * well * well / width);
            }
        }
        sum / (columns * POINTS) as f64
    }

    fn is_rotated(&self) -> bool {
        self.scene.geometry == Geometry::Axisymmetric
    }

    /// d_r/r and what it is at last over r, by rotation; nothing in the plane. On the axis, where the second is tested with
    /// functions that are zero, it is left out.
    fn hoop(&self, place: Point, director: &Director) -> [f64; 2] {
        if !self.is_rotated() || self.flaw == Some(Flaw::NoHoop) {
            return [0.0; 2];
        }
        if place.x < 1e-9 {
            return [director.gradient[0].x, 0.0];
        }
        let hoop = director.value.x / place.x;
        [hoop, hoop / place.x]
    }

    /// (B − β)/η.
    pub fn tension(&self, t: f64) -> f64 {
        self.scene.area.map_or(0.0, |area| {
            let target = area.target * self.surface_area(0.0);
            self.factor(Term::Tension) * (self.surface_area(t) - target) / area.penalty
        })
    }

    /// λ_anch δ1 and λ_anch δ2.
    fn anchoring(&self) -> [f64; 2] {
        let Some(anchoring) = self.scene.anchoring else {
            return [0.0; 2];
        };
        let preference = match anchoring.kind {
            AnchoringKind::None => [0.0, 0.0],
            AnchoringKind::Parallel => [0.0, 1.0],
            AnchoringKind::Homeotropic => [1.0, -1.0],
        };
        preference.map(|delta| anchoring.weight * delta)
    }

    /// δE/δφ − μ, which the source of the second equation of (3.21) is to balance.
    pub fn membrane_excess(&self, place: Point, t: f64, tension: f64) -> WeakForm {
        let width = self.scene.membrane.interface_width;
        let phase = self.phase.at(place, t);
        let (phi, grad) = (phase.value, phase.gradient);
        let (omega, omega_gradient) = self.omega(place, &phase);
        let (k, _) = self.curvature(place);
        let slope = match self.flaw {
            Some(Flaw::PrintedSecant) => 3.0 * (phi * phi - 1.0 - 2.0 * width * k * phi),
            _ => 3.0 * phi * phi - 1.0 - 2.0 * width * k * phi,
        };
        let mut form = WeakForm {
            flux: width * omega_gradient + tension * width * grad,
            load: slope * omega / width + tension * (phi * phi * phi - phi) / width
                - self.mu(&phase),
        };
        let (Some(nematic), Some(field)) = (&self.scene.nematic, &self.director) else {
            return form;
        };
        let director = field.at(place, t);
        let d = director.value;
        let [hoop, _] = self.hoop(place, &director);
        form.load += self.factor(Term::NematicPressure)
            * nematic.weight
            * indicator_slope(phi)
            * (0.5 * (square_of_gradient(&director) + hoop * hoop) + penalty(d, nematic.penalty));
        let [isotropic, along] = self.anchoring();
        let sign = match self.flaw {
            Some(Flaw::PrintedAnchoringSign) => -1.0,
            _ => self.factor(Term::AnchoringFlux),
        };
        form.flux += sign * (isotropic * d.norm_squared() * grad + along * d.dot(&grad) * d);
        form
    }

    /// Whether there is a substep 1.
    pub fn has_director(&self) -> bool {
        self.scene.nematic.is_some() && self.director.is_some()
    }

    /// ∂d/∂t / γ_nem + δE/δd for both components, which the source of substep 1 is to balance.
    pub fn director_excess(&self, place: Point, t: f64) -> [WeakForm; 2] {
        let (Some(nematic), Some(field)) = (&self.scene.nematic, &self.director) else {
            panic!("a scene without a director has no substep 1");
        };
        let phase = self.phase.at(place, t);
        let director = field.at(place, t);
        let (d, grad) = (director.value, phase.gradient);
        let inside = nematic.weight * indicator(phase.value);
        let square = d.norm_squared();
        let pull = match self.flaw {
            Some(Flaw::UntruncatedPenalty) => square - 1.0,
            _ if square <= 1.0 => square - 1.0,
            _ => 2.0 - 2.0 / square.sqrt(),
        } / (nematic.penalty * nematic.penalty);
        let [isotropic, along] = self.anchoring();
        let torque = isotropic * grad.norm_squared() * d + along * d.dot(&grad) * grad;
        let [_, hoop] = self.hoop(place, &director);
        let hoop = [hoop, 0.0];
        [0, 1].map(|i| WeakForm {
            flux: self.factor(Term::Elasticity) * inside * director.gradient[i],
            load: self.factor(Term::DirectorRate) * director.rate[i] / nematic.mobility
                + self.factor(Term::Elasticity) * inside * hoop[i]
                + self.factor(Term::Penalty) * inside * pull * d[i]
                + self.factor(Term::AnchoringTorque) * torque[i],
        })
    }
}

fn square_of_gradient(director: &Director) -> f64 {
    director.gradient.iter().map(Vector::norm_squared).sum()
}

/// P(d), truncated.
fn penalty(d: Vector, width: f64) -> f64 {
    let square = d.norm_squared();
    let scaled = if square <= 1.0 {
        0.25 * (square - 1.0).powi(2)
    } else {
        (square.sqrt() - 1.0).powi(2)
    };
    scaled / (width * width)
}

/// i(φ) = I'(φ).
fn indicator_slope(phi: f64) -> f64 {
    if phi.abs() < 1.0 {
        15.0 / 16.0 * (1.0 - phi * phi).powi(2)
    } else {
        0.0
    }
}

/// I(φ), as the integral of i from −1: 15/16 (φ − 2φ³/3 + φ⁵/5) + ½.
fn indicator(phi: f64) -> f64 {
    let phi = phi.clamp(-1.0, 1.0);
    0.5 + 15.0 / 16.0 * (phi - 2.0 * phi.powi(3) / 3.0 + phi.powi(5) / 5.0)
}
