//! One time step (a stand-in for the real room).

/// The discrete fields at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// φ.
    pub phi: Vec<f64>,
    /// ω.
    pub omega: Vec<f64>,
    /// μ.
    pub mu: Vec<f64>,
    /// d.
    pub director: Option<[Vec<f64>; 2]>,
}
