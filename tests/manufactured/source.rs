//! The source as an effect: it has no energy, and its director force and its membrane force are
//! minus what the exact solution leaves over in the continuous equations.
//!
//! A source does work. An effect accounts for that as its numerical dissipation (an effect of zero
//! energy dissipates all the work of its forces), so the energy law closes with sources as well and
//! stays a check of how well each step was solved.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use vesica::internal::fem::{QuadratureRule, Space};
use vesica::{
    DirectorForm, Effect, Interval, Kept, LedgerTerms, MembraneForce, Patch, PatchFields,
    PatchStep, Point, Room, Vector,
};

use super::model::{Model, WeakForm};

/// The time at the end of the step, set by who steps.
#[derive(Debug, Clone, Default)]
pub struct Clock(Arc<AtomicU64>);

impl Clock {
    /// Sets it.
    pub fn set(&self, t: f64) {
        self.0.store(t.to_bits(), Ordering::Relaxed);
    }

    fn now(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }
}

/// A weak form on a mesh: fluxes on the triangles, loads at the quadrature points.
#[derive(Debug)]
struct Table {
    flux: Vec<Vector>,
    load: Vec<f64>,
}

impl Table {
    fn new(space: &Space) -> Self {
        Self {
            flux: vec![Vector::zeros(); space.elements()],
            load: vec![0.0; space.points()],
        }
    }

    fn add_to(&self, patch: &Patch<'_>, flux: &mut [Vector], load: &mut [f64]) {
        for (sum, flux) in flux.iter_mut().zip(&self.flux[patch.element_range()]) {
            *sum += flux;
        }
        for (sum, load) in load.iter_mut().zip(&self.load[patch.point_range()]) {
            *sum += load;
        }
    }

    /// The work on a change of a P1 function, given by its values and gradients before and after.
    fn work(&self, patch: &Patch<'_>, values: [&[f64]; 2], gradients: [&[Vector]; 2]) -> f64 {
        let changes = values[1].iter().zip(values[0]);
        let by_load: Vec<f64> = changes
            .zip(&self.load[patch.point_range()])
            .map(|((new, old), load)| load * (new - old))
            .collect();
        let changes = gradients[1].iter().zip(gradients[0]);
        let by_flux: Vec<f64> = changes
            .zip(&self.flux[patch.element_range()])
            .map(|((new, old), flux)| flux.dot(&(new - old)))
            .collect();
        patch.integrate(&by_load) + patch.integrate_elements(&by_flux)
    }
}

/// Where weak forms are evaluated: loads at the points of the run's own rule, fluxes at seven points
/// of each triangle, whose mean is all that a P1 test function sees.
#[derive(Debug)]
struct Places {
    points: Vec<Point>,
    fine: Space,
    fine_points: Vec<Point>,
}

impl Places {
    fn new(space: &Space) -> Self {
        let fine = Space::new(space.mesh().clone(), QuadratureRule::Consistent);
        Self {
            points: space.point_positions(),
            fine_points: fine.point_positions(),
            fine,
        }
    }

    /// tables ← −forms.
    fn fill<const N: usize>(
        &self,
        tables: [&mut Table; N],
        forms: impl Fn(Point) -> [WeakForm; N],
    ) {
        let fine: Vec<_> = self.fine_points.iter().map(|place| forms(*place)).collect();
        let own: Vec<_>;
        let at_points = if self.points == self.fine_points {
            &fine
        } else {
            own = self.points.iter().map(|place| forms(*place)).collect();
            &own
        };
        for (index, table) in tables.into_iter().enumerate() {
            for (load, forms) in table.load.iter_mut().zip(at_points) {
                *load = -forms[index].load;
            }
            let mut means = vec![0.0; table.flux.len()];
            for axis in 0..2 {
                let values: Vec<f64> = fine.iter().map(|forms| forms[index].flux[axis]).collect();
                self.fine.whole().element_means(&values, &mut means);
                for (flux, mean) in table.flux.iter_mut().zip(&means) {
                    flux[axis] = -mean;
                }
            }
        }
    }
}

/// The source of a model.
#[derive(Debug)]
pub struct Source {
    model: Model,
    clock: Clock,
    places: Places,
    membrane: Table,
    director: [Table; 2],
}

impl Source {
    /// On the space of a run.
    pub fn new(model: Model, clock: Clock, space: &Space) -> Self {
        Self {
            model,
            clock,
            places: Places::new(space),
            membrane: Table::new(space),
            director: [Table::new(space), Table::new(space)],
        }
    }
}

impl Effect for Source {
    fn name(&self) -> &'static str {
        "source"
    }

    fn integral(&self, _: &Patch<'_>, _: &PatchFields, _: &mut Room) -> f64 {
        0.0
    }

    /// The clock was set before the step.
    fn set_interval(&mut self, _: Interval) {
        let (model, t) = (&self.model, self.clock.now());
        let tension = model.tension(t);
        self.places.fill([&mut self.membrane], |place| {
            [model.membrane_excess(place, t, tension)]
        });
        if model.has_director() {
            let [x, y] = &mut self.director;
            self.places
                .fill([x, y], |place| model.director_excess(place, t));
        }
    }

    fn add_director_force(&self, step: &PatchStep<'_>, form: &mut DirectorForm, _: &mut Room) {
        for (i, table) in self.director.iter().enumerate() {
            table.add_to(step.patch, &mut form.flux[i], &mut form.load[i]);
        }
    }

    fn add_membrane_force(&self, step: &PatchStep<'_>, _: &Kept, force: &mut MembraneForce) {
        let patch = step.patch;
        self.membrane
            .add_to(patch, &mut force.flux, &mut force.load);
    }

    fn add_dissipation(
        &self,
        step: &PatchStep<'_>,
        _: &Kept,
        terms: &mut LedgerTerms,
        _: &mut Room,
    ) {
        let (patch, old, new) = (step.patch, step.old, step.new);
        let mut work = self.membrane.work(
            patch,
            [&old.phi, &new.phi],
            [&old.phi_gradient, &new.phi_gradient],
        );
        if let (Some(old), Some(new)) = (&old.director, &new.director) {
            for (i, table) in self.director.iter().enumerate() {
                work += table.work(
                    patch,
                    [&old.values[i], &new.values[i]],
                    [&old.gradients[i], &new.gradients[i]],
                );
            }
        }
        terms.add("source", work);
    }
}
