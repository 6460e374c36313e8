//! The exact solutions: φ a sum of cosines, so that every derivative and μ are sums of the same
//! cosines, and d a vector of given length and angle. By rotation Bessel functions J₀ stand for the cosines along x.

use std::f64::consts::PI;

use vesica::{Point, Vector};

/// φ and what the equations need of it, at one place and time.
#[derive(Debug, Clone, Copy, Default)]
pub struct Phase {
    /// φ.
    pub value: f64,
    /// ∇φ.
    pub gradient: Vector,
    /// Δφ.
    pub laplacian: f64,
    /// ∇Δφ.
    pub laplacian_gradient: Vector,
    /// γ_ben μ, where γ_ben Δμ = ∂φ/∂t: the first equation of (3.21) needs no source.
    pub scaled_potential: f64,
}

/// One cosine: (steady + fading e^(−t)) cos(kπx) cos(lπy); by rotation with J₀(j x) for the first, j the k-th zero of J₁.
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
    /// Whether the domain is rotated about x = 0.
    pub is_rotated: bool,
}

/// The zeros of J₁ (Abramowitz and Stegun, table 9.5).
const ZEROS: [f64; 4] = [
    0.0,
    3.831_705_970_207_512,
    7.015_586_669_815_619,
    10.173_468_135_062_722,
];

/// J₀ or J₁ by its power series: the arguments are at most 11, and no digit is lost that matters.
fn bessel(order: i32, x: f64) -> f64 {
    let mut term = (0.5 * x).powi(order);
    let mut sum = term;
    for m in 1..60 {
        term *= -0.25 * x * x / f64::from(m * (m + order));
        sum += term;
    }
    sum
}

impl PhaseField {
    /// Everything at a place and a time.
    pub fn at(&self, place: Point, t: f64) -> Phase {
        let (x, y) = (place.x, place.y);
        let mut sum = Phase::default();
        for mode in self.modes {
            let [k, q] = mode.waves.map(|wave| PI * f64::from(wave));
            let (p, cos_x, sin_x) = if self.is_rotated {
                let zero = ZEROS[mode.waves[0] as usize];
                (zero, bessel(0, zero * x), bessel(1, zero * x))
            } else {
                (k, (k * x).cos(), (k * x).sin())
            };
            let (sin_y, cos_y) = (q * y).sin_cos();
            let amplitude = mode.steady + mode.fading * (-t).exp();
            let rate = -mode.fading * (-t).exp();
            let eigenvalue = -(p * p + q * q);
            let value = amplitude * cos_x * cos_y;
            let gradient = -amplitude * Vector::new(p * sin_x * cos_y, q * cos_x * sin_y);
            sum.value += value;
            sum.gradient += gradient;
            sum.laplacian += eigenvalue * value;
            sum.laplacian_gradient += eigenvalue * gradient;
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
    pub value: Vector,
    /// ∇d_x and ∇d_y.
    pub gradient: [Vector; 2],
    /// ∂d/∂t.
    pub rate: Vector,
}

/// d = ρ (cos θ, sin θ) with ρ = 1 + s e^(−t) cos(πx) cos(πy) and θ = 0.3 + x − 2y + t/2: shorter
/// than 1 in one half of the domain and longer in the other, so that both branches of the truncated
/// potential act. It has a flux through the wall, which the source takes in. By rotation θ = π/2 + x(1 − 2y + t/2), along the
/// axis where x = 0.
#[derive(Debug, Clone, Copy)]
pub struct DirectorField {
    /// s.
    pub swing: f64,
    /// Whether the domain is rotated about x = 0.
    pub is_rotated: bool,
}

impl DirectorField {
    /// Everything at a place and a time.
    pub fn at(&self, place: Point, t: f64) -> Director {
        let (x, y) = (place.x, place.y);
        let [(sin_x, cos_x), (sin_y, cos_y)] = [(PI * x).sin_cos(), (PI * y).sin_cos()];
        let swing = self.swing * (-t).exp();
        let length = 1.0 + swing * cos_x * cos_y;
        let length_gradient = -swing * PI * Vector::new(sin_x * cos_y, cos_x * sin_y);
        let length_rate = -swing * cos_x * cos_y;
        let (angle, angle_gradient, angle_rate) = if self.is_rotated {
            let slope = 1.0 - 2.0 * y + 0.5 * t;
            let gradient = Vector::new(slope, -2.0 * x);
            (0.5 * PI + x * slope, gradient, 0.5 * x)
        } else {
            (0.3 + x - 2.0 * y + 0.5 * t, Vector::new(1.0, -2.0), 0.5)
        };
        let (sin, cos) = angle.sin_cos();
        let (along, across) = (Vector::new(cos, sin), Vector::new(-sin, cos));
        let gradient =
            [0, 1].map(|i| along[i] * length_gradient + length * across[i] * angle_gradient);
        Director {
            value: length * along,
            gradient,
            rate: length_rate * along + length * angle_rate * across,
        }
    }
}
