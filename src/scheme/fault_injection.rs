//! StepContext in a step where a test may spoil a value. Outside of the tests of this crate [`tap`] is empty
//! and costs nothing.

/// A place in a step, named after what is computed there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// The right side of substep 1.
    DirectorLoad,
    /// A product with the matrix of substep 1.
    DirectorProduct,
    /// A component of dⁿ⁺¹, from substep 1.
    Director(usize),
    /// φ of an iterate.
    Phi,
    /// ω of an iterate.
    Omega,
    /// μ of an iterate.
    Mu,
    /// r₁.
    Residual,
    /// T, A and C of the linearised equations.
    Tangent,
    Secant,
    Local,
    /// What the preconditioner makes of a vector.
    Preconditioner,
    /// A product of the Krylov iteration.
    Product,
    /// The solution of the linearised equations.
    Increment,
    /// A field of the solved step, before the books are closed: φ, ω, μ, d_x, d_y.
    Solved(usize),
    /// An energy of the solved step.
    Energy,
}

#[cfg(not(test))]
#[inline(always)]
pub(super) fn tap(_: Place, _: &mut [f64]) {}

#[cfg(test)]
pub(super) use armed::tap;

#[cfg(test)]
pub(super) mod armed {
    use super::Place;
    use std::cell::Cell;

    /// What becomes of the entry of largest magnitude.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Spoiling {
        /// It becomes this value.
        Becomes(f64),
        /// It changes its sign.
        Negated,
    }

    /// A fault: which time the place is come by, and whether every time from then on.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Fault {
        pub place: Place,
        pub passes: u32,
        pub lasting: bool,
        pub spoiling: Spoiling,
    }

    thread_local! {
        static FAULT: Cell<Option<Fault>> = const { Cell::new(None) };
        static FIRED: Cell<u32> = const { Cell::new(0) };
    }

    /// Takes a step with a fault; returns how often it happened.
    pub fn with_fault(fault: Fault, step: impl FnOnce()) -> u32 {
        FIRED.set(0);
        FAULT.set(Some(fault));
        step();
        FAULT.set(None);
        FIRED.get()
    }

    pub fn tap(place: Place, values: &mut [f64]) {
        let Some(mut fault) = FAULT.get().filter(|fault| fault.place == place) else {
            return;
        };
        if fault.passes > 0 {
            fault.passes -= 1;
            FAULT.set(Some(fault));
            return;
        }
        let largest = |most: usize, entry: usize| {
            if values[entry].abs() > values[most].abs() {
                entry
            } else {
                most
            }
        };
        let entry = (0..values.len()).fold(0, largest);
        if let Some(value) = values.get_mut(entry) {
            *value = match fault.spoiling {
                Spoiling::Becomes(new) => new,
                Spoiling::Negated => -*value,
            };
        }
        FIRED.set(FIRED.get() + 1);
        if !fault.lasting {
            FAULT.set(None);
        }
    }
}
