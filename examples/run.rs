//! A run from Rust: the first steps of case 3 on a coarse mesh, with its energies.
//!
//!     cargo run --release --example run

use vesica::{Scene, Simulation, find_preset};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = find_preset("case3")?;
    let settings = ["mesh.cells=48", "membrane.interface_width=0.02"].map(str::to_owned);
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let scene = Scene::parse(text, "case3", &settings, &mut no_files)?;

    let mut simulation = Simulation::new(&scene)?;
    for _ in 0..20 {
        let report = simulation.advance()?;
        print!("t = {:.1e}  E = {:8.3}", report.t, report.total_energy);
        for energy in &report.energies {
            print!("  {} {:.3}", energy.name, energy.value);
        }
        println!("  residual of the energy law {:.0e}", report.law_residual);
    }
    Ok(())
}
