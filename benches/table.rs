//! The table of speeds of the guide's page on performance, as Markdown: `cargo bench --bench table`. It takes some ten
//! minutes on a machine that does nothing else.

use std::time::Instant;

use vesica::scene::{Scene, find_preset};
use vesica::simulation::{Simulation, cores};

/// Steps before the first that is measured: the extrapolated guess needs a few to be good.
const WARM_UP: usize = 10;

/// What is measured of steps takes about so many seconds, but at least so many steps.
const SECONDS: f64 = 4.0;
const LEAST_STEPS: usize = 10;

fn simulation(case: &str, settings: &[String], threads: usize) -> Simulation {
    let text = find_preset(case).expect("it is built in");
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let scene = Scene::parse(text, case, settings, &mut no_files).expect("a sound scene");
    let mut simulation = Simulation::new(&scene).expect("a sound scene");
    simulation.set_threads(threads);
    simulation
}

/// Milliseconds a step of length Table 1's.
fn milliseconds(cells: usize, quadrature: &str, threads: usize) -> f64 {
    let settings = [
        format!("mesh.cells={cells}"),
        format!("solver.quadrature={quadrature}"),
    ];
    let mut simulation = simulation("case3", &settings, threads);
    for _ in 0..WARM_UP {
        simulation.advance().expect("a step");
    }
    let begin = Instant::now();
    let mut steps = 0;
    while steps < LEAST_STEPS || begin.elapsed().as_secs_f64() < SECONDS {
        simulation.advance().expect("a step");
        steps += 1;
    }
    1e3 * begin.elapsed().as_secs_f64() / steps as f64
}

/// The steps and the seconds of a run with chosen steps.
fn whole_run(case: &str, tolerance: &str, threads: usize) -> (u64, f64) {
    let settings = [format!("time.tolerance={tolerance}")];
    let mut simulation = simulation(case, &settings, threads);
    let end = simulation.scene().time.end;
    let begin = Instant::now();
    while simulation.report().t < end * (1.0 - 1e-9) {
        simulation.advance().expect("a step");
    }
    (simulation.report().step, begin.elapsed().as_secs_f64())
}

fn main() {
    let most = cores().min(2);
    println!(
        "| cells | nodes | quadrature | 1 thread: ms a step | ns a node | growth | {most} threads: ms | ratio |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    for quadrature in ["lumped", "consistent"] {
        let mut before = None;
        for cells in [60, 120, 240, 480] {
            let nodes = (cells + 1) * (cells + 1);
            let [one, several] = [1, most].map(|threads| milliseconds(cells, quadrature, threads));
            let growth = before.map_or(String::new(), |before: f64| format!("{:.1}", one / before));
            let of_node = 1e6 * one / nodes as f64;
            println!(
                "| {cells} | {nodes} | {quadrature} | {one:.1} | {of_node:.0} | {growth} | {several:.1} | {:.2} |",
                several / one
            );
            before = Some(one);
        }
    }
    println!();
    println!("| run | steps | 1 thread: s | {most} threads: s | ratio |");
    println!("| --- | --- | --- | --- | --- |");
    for case in ["case3", "case4"] {
        for tolerance in ["1e-2", "1e-3", "1e-4"] {
            let [(steps, one), (_, several)] =
                [1, most].map(|threads| whole_run(case, tolerance, threads));
            println!(
                "| `{case} --set time.tolerance={tolerance}` | {steps} | {one:.1} | {several:.1} | {:.2} |",
                several / one
            );
        }
    }
}
