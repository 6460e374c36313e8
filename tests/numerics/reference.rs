//! Another program's numbers: histories that FreeFem++ computed with the same scheme, on the same
//! mesh, from the same nodal φ⁰. Where they come from is said in tests/reference/README.md.

use crate::common::{named, scene, scheme};
use vesica::StepReport;

/// A scene, and its history in the other program.
struct Reference {
    scene: &'static str,
    history: &'static str,
}

const CASE_1_PARALLEL: Reference = Reference {
    scene: include_str!("../reference/case1-parallel-80.toml"),
    history: include_str!("../reference/case1-parallel-80.csv"),
};
const CASE_3_HOMEOTROPIC: Reference = Reference {
    scene: include_str!("../reference/case3-homeotropic-80.toml"),
    history: include_str!("../reference/case3-homeotropic-80.csv"),
};

/// Rows of each history: steps 0, 5, …, 100.
const ROWS: usize = 21;

/// What is asked for, relative (10⁻⁸ is reached: φ⁰ differs by that).
const AGREEMENT: f64 = 1e-6;

/// One row of a history.
#[derive(Debug)]
struct Row {
    step: usize,
    total: f64,
    energies: [(&'static str, f64); 4],
    phase_integral: f64,
    surface_area: f64,
}

impl Reference {
    fn rows(&self) -> Vec<Row> {
        let mut lines = self.history.lines();
        let header = "step,t,E_total,E_bending,E_area,E_nematic,E_anchoring,A,B";
        assert_eq!(lines.next(), Some(header));
        lines.map(row).collect()
    }
}

fn row(line: &str) -> Row {
    let cells: Vec<f64> = line
        .split(',')
        .map(|cell| cell.parse().expect("a number"))
        .collect();
    let [step, _, total, bending, area, nematic, anchoring, a, b] = cells[..] else {
        panic!("nine cells: {line}");
    };
    Row {
        step: step as usize,
        total,
        energies: [
            ("bending", bending),
            ("area", area),
            ("nematic", nematic),
            ("anchoring", anchoring),
        ],
        phase_integral: a,
        surface_area: b,
    }
}

/// The largest relative difference of a report to a row: energies relative to E_total.
fn difference(report: &StepReport, row: &Row) -> f64 {
    let energies = row
        .energies
        .map(|(name, value)| (named(&report.energies, name) - value) / row.total);
    let others = [
        report.total_energy / row.total - 1.0,
        report.phase_integral / row.phase_integral - 1.0,
        report.surface_area / row.surface_area - 1.0,
    ];
    crate::common::greatest(&energies).max(crate::common::greatest(&others))
}

/// Runs the scene with Δt times `stretch`; the largest difference to the first `rows` rows.
fn run(reference: &Reference, rows: usize, stretch: f64, settings: &[&str]) -> f64 {
    let scene = scene(reference.scene, settings);
    let mut scheme = scheme(&scene);
    let history = reference.rows();
    assert_eq!(history.len(), ROWS);
    let mut taken = 0;
    let mut greatest = 0.0_f64;
    for row in &history[..rows] {
        while taken < row.step {
            taken += 1;
            if let Err(error) = scheme.step(stretch * scene.time.step) {
                panic!("step {taken}: {error}");
            }
        }
        let difference = difference(scheme.report(), row);
        println!("step {taken}: {difference:.1e}");
        greatest = greatest.max(difference);
    }
    greatest
}

#[test]
fn case_1_parallel_agrees() {
    let difference = run(&CASE_1_PARALLEL, ROWS, 1.0, &[]);
    assert!(difference < AGREEMENT, "{difference:e}");
}

#[test]
fn case_3_homeotropic_agrees() {
    let difference = run(&CASE_3_HOMEOTROPIC, ROWS, 1.0, &[]);
    assert!(difference < AGREEMENT, "{difference:e}");
}

/// The comparison sees a Δt that is off by one per cent, the other quadrature, and the other
/// projection: each of them at once, by more than a hundred times what is allowed.
#[test]
fn what_is_slightly_wrong_does_not_agree() {
    let reference = &CASE_3_HOMEOTROPIC;
    for (stretch, settings) in [
        (1.01, &[][..]),
        (1.0, &["solver.quadrature=lumped"]),
        (1.0, &["vesicle.projection=ritz"]),
    ] {
        let difference = run(reference, 3, stretch, settings);
        assert!(
            difference > 100.0 * AGREEMENT,
            "{difference:e} with Δt times {stretch}, {settings:?}"
        );
    }
}
