//! A picture from Rust: φ, the membrane and the director after some steps, as PNG, SVG, CSV and VTU.
//!
//!     cargo run --release --example picture

use std::path::Path;

use vesica::{Field, FigureOptions, Scene, Simulation, View, find_preset, save_view};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let scene = Scene::parse(
        find_preset("case3-quick")?,
        "case3-quick",
        &[],
        &mut no_files,
    )?;
    let mut simulation = Simulation::new(&scene)?;
    for _ in 0..3 {
        simulation.advance()?;
    }
    let view = View {
        name: "example",
        scene: &scene,
        mesh: simulation.mesh(),
        state: simulation.state(),
        report: simulation.report(),
        field: Field::Phase,
        theory: None,
        command: "cargo run --example picture",
    };
    let folder = Path::new("figures/example");
    std::fs::create_dir_all(folder)?;
    for file in save_view(&view, &FigureOptions::view(), folder)? {
        println!("{}", file.display());
    }
    Ok(())
}
