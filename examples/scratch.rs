use std::time::Instant;
use vesica::fem::*;
use vesica::physics::*;
fn time(name: &str, n: usize, mut f: impl FnMut()) {
    for _ in 0..5 {
        f();
    }
    let mut best = f64::MAX;
    for _ in 0..n {
        let t = Instant::now();
        f();
        best = best.min(t.elapsed().as_secs_f64());
    }
    println!("  {name}: {:.3} ms", best * 1e3);
}
fn main() {
    let mut none = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let scene =
        vesica::scene::Scene::parse(vesica::scene::preset("case3").unwrap(), "x", &[], &mut none)
            .unwrap();
    for rule in [Rule::Lumped, Rule::Consistent] {
        println!("{rule:?}");
        let mesh = std::sync::Arc::new(Mesh::structured(120, 0.0, 0).unwrap());
        let s = Space::new(mesh, rule);
        let x: Vec<f64> = (0..s.nodes()).map(|i| (i as f64).sin()).collect();
        let mut y = vec![0.0; s.nodes()];
        let mut p = vec![0.0; s.points()];
        let mut e = vec![0.0; s.elements()];
        let mut g = vec![[0.0; 2]; s.elements()];
        let t = vec![[1.0, 0.5, 2.0]; s.elements()];
        time("interpolate", 50, || s.interpolate(&x, &mut p));
        time("gradient", 50, || s.gradient(&x, &mut g));
        time("integrate", 50, || {
            std::hint::black_box(s.integrate(&p));
        });
        time("add_load", 50, || s.add_load(&p, &mut y));
        time("add_flux", 50, || s.add_flux(&g, &mut y));
        time("element_means", 50, || s.element_means(&p, &mut e));
        time("from_elements", 50, || s.from_elements(&e, &mut p));
        let mut f = s.new_form();
        time("assemble_mass", 50, || s.assemble_mass(&p, &mut f));
        let mut k = s.stiffness().clone();
        time("add_stiffness", 50, || {
            s.assembly().add_stiffness(s.mesh(), &t, &mut k.values)
        });
        time("add_weighted", 50, || {
            s.assembly()
                .add_weighted_stiffness(s.mesh(), &e, &mut k.values)
        });
        time("tensor_energy", 50, || {
            std::hint::black_box(s.tensor_energy(&t, &g));
        });
        let mut m = MassInverse::new(&s);
        time("mass apply 7", 50, || m.apply(&s, &x, &mut y, 7));
        time("mass mult", 50, || s.mass().multiply(&x, &mut y));
        let mut old = Sample::new(&s, true);
        let d = [x.clone(), x.clone()];
        old.set_phi(&s, &x);
        old.set_omega(&s, &x);
        old.set_director(&s, &d);
        let new = old.clone();
        time("set_phi", 50, || old.set_phi(&s, &x));
        let mut eff = Effects::from_scene(&scene, &s, &old);
        let mut form = DirectorForm::new(&s);
        let mut force = MembraneForce::new(&s);
        let mut lin = MembraneLinearisation::new(&s);
        let mut terms = Vec::new();
        time("bending omega_load", 50, || {
            eff.bending.omega_load(&s, &old, &mut y)
        });
        for ef in eff.iter_mut() {
            println!(" {}", ef.name());
            time("energy", 50, || {
                std::hint::black_box(ef.energy(&s, &old));
            });
            time("director", 50, || {
                ef.add_director_force(&s, &old, &mut form)
            });
            time("begin", 50, || ef.begin_membrane(&s, &old, &new));
            time("force", 50, || {
                ef.add_membrane_force(&s, &old, &new, &mut force)
            });
            time("lin", 50, || {
                ef.add_membrane_linearisation(
                    &s,
                    &old,
                    &new,
                    vesica::scene::Iteration::Newton,
                    &mut lin,
                )
            });
            time("dissip", 50, || {
                terms.clear();
                ef.dissipation(&s, &old, &new, &mut terms)
            });
        }
    }
}
