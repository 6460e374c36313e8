//! The exact solutions: φ a sum of cosines, so that every derivative and μ are sums of the same
//! cosines, and d a vector of given length and angle.

use std::f64::consts::PI;

/// φ and what the equations need of it, at one place and time.
#[derive(Debug, Clone, Copy, Default)]
pub struct Phase {
    /// φ.
    pub value: f64,
    /// ∇φ.
    pub gradient: [f64; 2],
    /// Δφ.
    pub laplacian: f64,
    /// ∇Δφ.
    pub laplacian_gradient: [f64; 2],
    /// γ_ben μ, where γ_ben Δμ = ∂φ/∂t: the first equation of (3.21) needs no source.
    pub scaled_potential: f64,
}

/// One cosine: (steady + fading e^(−t)) cos(kπx) cos(lπy).
#[derive(Debug, Clone, Copy)]
pub struct Mode {
    /// k and l.
    pub waves: [u32; 2],
    /// Its amplitude at t = ∞.
    pub steady: f64,
    /// What it has more at t = 0; zero where k = l = 0, since ∫φ is conserved.
    pub fading: f64,
}

/// A sum of cosines: ∇φ·n = ∇μ·n = 0 on the boundary of the unit square.
#[derive(Debug, Clone, Copy)]
pub struct PhaseField {
    /// Its terms.
    pub modes: &'static [Mode],
}

impl PhaseField {
    /// Everything at a place and a time.
    pub fn at(&self, [x, y]: [f64; 2], t: f64) -> Phase {
        let mut sum = Phase::default();
        for mode in self.modes {
            let [p, q] = mode.waves.map(|wave| PI * f64::from(wave));
            let [(sin_x, cos_x), (sin_y, cos_y)] = [(p * x).sin_cos(), (q * y).sin_cos()];
            let amplitude = mode.steady + mode.fading * (-t).exp();
            let rate = -mode.fading * (-t).exp();
            let eigenvalue = -(p * p + q * q);
            let value = amplitude * cos_x * cos_y;
            let gradient = [
                -amplitude * p * sin_x * cos_y,
                -amplitude * q * cos_x * sin_y,
            ];
            sum.value += value;
            sum.laplacian += eigenvalue * value;
            for (axis, entry) in gradient.into_iter().enumerate() {
                sum.gradient[axis] += entry;
                sum.laplacian_gradient[axis] += eigenvalue * entry;
            }
            if eigenvalue < 0.0 {
                sum.scaled_potential += rate / eigenvalue * cos_x * cos_y;
            }
        }
        sum
    }
}

/// d and what the equations need of it, at one place and time.
#[derive(Debug, Clone, Copy)]
pub struct Director {
    /// d.
    pub value: [f64; 2],
    /// ∇d_x and ∇d_y.
    pub gradient: [[f64; 2]; 2],
    /// ∂d/∂t.
    pub rate: [f64; 2],
}

/// d = ρ (cos θ, sin θ) with ρ = 1 + s e^(−t) cos(πx) cos(πy) and θ = 0.3 + x − 2y + t/2: shorter
/// than 1 in one half of the domain and longer in the other, so that both branches of the truncated
/// potential act. It has a flux through the wall, which the source takes in.
#[derive(Debug, Clone, Copy)]
pub struct DirectorField {
    /// s.
    pub swing: f64,
}

impl DirectorField {
    /// Everything at a place and a time.
    pub fn at(&self, [x, y]: [f64; 2], t: f64) -> Director {
        let [(sin_x, cos_x), (sin_y, cos_y)] = [(PI * x).sin_cos(), (PI * y).sin_cos()];
        let swing = self.swing * (-t).exp();
        let length = 1.0 + swing * cos_x * cos_y;
        let length_gradient = [-swing * PI * sin_x * cos_y, -swing * PI * cos_x * sin_y];
        let length_rate = -swing * cos_x * cos_y;
        let (sin, cos) = (0.3 + x - 2.0 * y + 0.5 * t).sin_cos();
        let (angle_gradient, angle_rate) = ([1.0, -2.0], 0.5);
        let (along, across) = ([cos, sin], [-sin, cos]);
        let derivative = |of_length: f64, of_angle: f64| {
            [0, 1].map(|i| of_length * along[i] + length * of_angle * across[i])
        };
        let [by_x, by_y] =
            [0, 1].map(|axis| derivative(length_gradient[axis], angle_gradient[axis]));
        Director {
            value: along.map(|entry| length * entry),
            gradient: [[by_x[0], by_y[0]], [by_x[1], by_y[1]]],
            rate: derivative(length_rate, angle_rate),
        }
    }
}
