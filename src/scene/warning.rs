//! What is allowed in a scene but probably not meant.

use std::fmt;

use super::significant::{brief, significant};
use super::tables::{Geometry, Mesh, Quadrature, Scene};

/// Cells that an interface of width ε should span, for accurate energies.
const CELLS_FOR_ENERGIES: f64 = 3.0;
/// Cells that it must span for the membrane to move freely: on a coarser mesh it sticks.
const CELLS_FOR_SHAPES: f64 = 1.0;

/// The band of fine edges on either side of the membrane, over ε, that holds the interface: beyond 3 ε, 1 − |φ| is
/// below 2.9 % (tanh(3/√2)).
const BAND_FOR_INTERFACE: f64 = 3.0;

/// What is allowed in a scene but probably not meant.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// ε spans fewer than three cells of the mesh.
    ThinInterface {
        /// ε.
        interface_width: f64,
        /// 1/h.
        cells: usize,
    },
    /// ε spans fewer than three triangles of a mesh that is no grid.
    ThinInterfaceInTriangles {
        /// ε.
        interface_width: f64,
        /// The mean length of an edge at the membrane.
        edge: f64,
        /// The key by which it is made smaller; none where the mesh is from a file.
        key: Option<&'static str>,
    },
    /// Triangles are nearly flat.
    Slivers {
        /// How many.
        count: usize,
        /// They have an angle below this, in degrees.
        below: f64,
        /// The middle of the worst.
        at: [f64; 2],
        /// Its smallest and its greatest angle, in degrees.
        angles: [f64; 2],
        /// Whether `mesh.jitter` made them; otherwise they are in the mesh's file.
        is_jittered: bool,
    },
    /// A mesh that follows the membrane is fine in less than the interface.
    NarrowBand {
        /// `mesh.band`.
        band: f64,
        /// ε.
        interface_width: f64,
    },
    /// A mesh that follows the membrane, and the lumped rule.
    LumpedOnAdaptiveMesh,
    /// φ⁰ changes its sign nowhere; only where it is random or from a file.
    NoMembrane {
        /// Whether it is positive.
        inside: bool,
    },
    /// By rotation a uniform d⁰ that is not along the axis: the axis is a line of defect.
    DefectOnAxis {
        /// η_d.
        penalty: f64,
    },
    /// The director turns by no whole number of turns around a point, so that it jumps along a line.
    FractionalWinding {
        /// The point.
        center: [f64; 2],
        /// The sum of the windings there.
        winding: f64,
    },
    /// T is no multiple of Δt.
    EndBetweenSteps {
        /// T.
        end: f64,
        /// Δt.
        step: f64,
        /// How many steps there will be.
        steps: u64,
    },
    /// The vesicle touches or crosses ∂Ω.
    VesicleAtWall {
        /// The smallest distance from the membrane (φ⁰ = 0) to ∂Ω; ≤ 0 where it crosses it.
        distance: f64,
        /// ε.
        interface_width: f64,
    },
    /// By the isoperimetric inequality no shape of this volume has the surface area β: volume is
    /// conserved, so β²/B(φ⁰)² ≥ 4π·area/length² of the initial shape, or by rotation β³/B(φ⁰)³ ≥
    /// 36π·volume²/surface³.
    TargetOutOfReach {
        /// β/B(φ⁰), `area.target`.
        target: f64,
        /// The quotient of the initial shape.
        quotient: f64,
        /// Whether it is that of a curve or of a body of rotation.
        geometry: Geometry,
    },
    /// A change that the run does not reach.
    ChangeAfterEnd {
        /// When it begins.
        at: f64,
        /// T.
        end: f64,
    },
    /// A field that the length of the director cannot withstand: −½ χ |H|² |d|² falls faster than
    /// λ_nem P(d) grows.
    FieldTooStrong {
        /// χ |H|².
        pull: f64,
        /// 2 λ_nem/η_d².
        bound: f64,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::ThinInterface {
                interface_width,
                cells,
            } => {
                let spanned = interface_width * cells as f64;
                let place = format!(
                    "the interface spans {} cells of the mesh (membrane.interface_width · mesh.cells \
                     = {interface_width:?} · {cells})",
                    significant(spanned, 3),
                );
                let enough = |wanted: f64| {
                    format!("mesh.cells = {} or more", (wanted / interface_width).ceil())
                };
                thin(f, spanned, &place, enough)
            }
            Self::ThinInterfaceInTriangles {
                interface_width,
                edge,
                key,
            } => {
                let spanned = interface_width / edge;
                let place = format!(
                    "the interface spans {} triangles of the mesh (membrane.interface_width = \
                     {interface_width:?}, edges at the membrane {})",
                    significant(spanned, 3),
                    significant(edge, 3),
                );
                let enough = |wanted: f64| {
                    let edge = interface_width / wanted;
                    match key {
                        Some(key) => format!("{key} = {edge:.2e} or less"),
                        None => format!("a mesh with edges of {edge:.2e} or less there"),
                    }
                };
                thin(f, spanned, &place, enough)
            }
            Self::Slivers {
                count,
                below,
                at: [x, y],
                angles: [least, greatest],
                is_jittered,
            } => {
                let triangles = match count {
                    1 => "1 triangle of the mesh has".to_owned(),
                    count => format!("{count} triangles of the mesh have"),
                };
                write!(
                    f,
                    "{triangles} an angle below {below}°; the worst, about ({}, {}), has angles from {}° to \
                     {greatest:.2}°: gradients are inaccurate there, and the linear systems hard to solve; {}",
                    significant(x, 3),
                    significant(y, 3),
                    significant(least, 2),
                    if is_jittered {
                        "lower mesh.jitter"
                    } else {
                        "mesh the domain again without them (in Gmsh: Mesh.Optimize, and no two points or \
                         curves that nearly meet)"
                    },
                )
            }
            Self::NarrowBand {
                band,
                interface_width,
            } => write!(
                f,
                "the mesh is fine within mesh.band = {band:?} of the membrane, and the interface is wider: take \
                 {:.2e} or more (3 \u{3b5}), else the error is that of the coarse mesh beside it",
                BAND_FOR_INTERFACE * interface_width,
            ),
            Self::LumpedOnAdaptiveMesh => f.write_str(
                "with solver.quadrature = \"lumped\" the bending energy rises about threefold each time the mesh \
                 is made again, and the result is not to be trusted: take \"consistent\", or a mesh that stays",
            ),
            Self::NoMembrane { inside } => write!(
                f,
                "the initial φ is {} everywhere: there is no membrane, so neither a vesicle nor what acts \
                 on one, until φ changes its sign somewhere",
                if inside { "positive" } else { "negative or 0" },
            ),
            Self::DefectOnAxis { penalty } => write!(
                f,
                "by rotation this nematic.initial points away from the axis on all sides, so the axis is a line of defect: \
                 its core is about as wide as nematic.penalty = {penalty:?}, and its energy grows like the logarithm of \
                 that; [0.0, 1.0] is along the axis"
            ),
            Self::FractionalWinding {
                center: [x, y],
                winding,
            } => {
                let jump = if (2.0 * winding).fract() == 0.0 {
                    "to −d"
                } else {
                    "to another direction"
                };
                write!(
                    f,
                    "the director turns {} times around ({}, {}), which is no whole number: it is \
                     a vector here, for which d and −d are not the same, so it jumps from d {jump} along a \
                     line that begins there, and the line costs energy as a wall does; take whole numbers \
                     for the winding, such as 1 or −1",
                    brief(winding),
                    brief(x),
                    brief(y),
                )
            }
            Self::EndBetweenSteps { end, step, steps } => write!(
                f,
                "the end, t = {end:e}, is no multiple of time.step = {step:e}: the run takes {steps} steps and \
                 ends at t = {:e}",
                rounded(steps as f64 * step),
            ),
            Self::VesicleAtWall {
                distance,
                interface_width,
            } => {
                if distance.abs() < 0.05 * interface_width {
                    f.write_str("the membrane touches the wall")?;
                } else if distance > 0.0 {
                    let distance = significant(distance, 2);
                    write!(f, "the membrane comes within {distance} of the wall")?;
                } else {
                    let distance = significant(-distance, 2);
                    write!(f, "the vesicle reaches across the wall (by {distance})")?;
                }
                write!(
                    f,
                    ", and its interface is about {} wide (4 · membrane.interface_width): the \
                     wall takes part in what happens; move the vesicle (vesicle.center) or make it \
                     smaller",
                    significant(4.0 * interface_width, 2),
                )
            }
            Self::ChangeAfterEnd { at, end } => write!(
                f,
                "the change at t = {at:?} never begins: the run ends at time.end = {end:?}"
            ),
            Self::FieldTooStrong { pull, bound } => write!(
                f,
                "the field draws the director out without end: field.weight · field.strength² = \
                 {} must be below 2 · nematic.weight/nematic.penalty² = {}, or nothing keeps |d| \
                 near 1",
                brief(pull),
                significant(bound, 6),
            ),
            Self::TargetOutOfReach {
                target,
                quotient,
                geometry,
            } => {
                let (power, formula, least) = match geometry {
                    Geometry::Planar => ("²", "4π·area/length²", quotient.sqrt()),
                    Geometry::Axisymmetric => ("³", "36π·volume²/surface³", quotient.cbrt()),
                };
                write!(
                    f,
                    "the area can never reach its target: the volume is conserved, so area.target{power} \
                     must be at least {formula} of the initial shape = {} (isoperimetric \
                     inequality), and it is {}; the smallest target within reach is {}",
                    significant(quotient, 4),
                    significant(target.powi(isoperimetric_power(geometry)), 4),
                    significant(least, 4),
                )
            }
        }
    }
}

/// With this power of length over the area of a curve, or of the surface over the volume of a body, the isoperimetric quotient goes.
pub fn isoperimetric_power(geometry: Geometry) -> i32 {
    match geometry {
        Geometry::Planar => 2,
        Geometry::Axisymmetric => 3,
    }
}

/// Without the digits that rounding leaves: 9.999e-4, not 9.998999999999999e-4.
fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// Whether there are fewer cells than these. Rounding must not make 0.03 · 100 fewer than 3.
fn is_fewer(spanned: f64, cells: f64) -> bool {
    spanned * (1.0 + f64::EPSILON) < cells
}

/// What an interface that spans too few cells means, why, what to take in its place, and what that takes. `place` says
/// what it spans; `enough` says what to take for as many cells as are wanted.
fn thin(
    f: &mut fmt::Formatter<'_>,
    spanned: f64,
    place: &str,
    enough: impl Fn(f64) -> String,
) -> fmt::Result {
    // In two dimensions.
    let price = |wanted: f64| match (wanted / spanned).powi(2) {
        nodes if nodes < 1.5 => "hardly more time".to_owned(),
        nodes => format!(
            "{} times the nodes and at least the time",
            significant(nodes, 2)
        ),
    };
    let energies = format!(
        "for accurate energies take {} ({})",
        enough(CELLS_FOR_ENERGIES),
        price(CELLS_FOR_ENERGIES)
    );
    if is_fewer(spanned, CELLS_FOR_SHAPES) {
        return write!(
            f,
            "at this mesh the shape is not to be trusted, nor are the energies: {place}, fewer than \
             {CELLS_FOR_SHAPES}, so the membrane sticks to it; for shapes take {} ({}), and {energies}",
            enough(CELLS_FOR_SHAPES),
            price(CELLS_FOR_SHAPES)
        );
    }
    write!(
        f,
        "at this mesh the bending energy is too high: {place}, fewer than {CELLS_FOR_ENERGIES} (a circle's is too high \
         by 83 % where it spans 1.2, 7.5 % at 2.4, 1.9 % at 3.6; by more with lumped quadrature); {energies}"
    )
}

/// The warnings that need no more than the scene's numbers and `edge`, the length of an edge at the
/// membrane; where that is not known, it is the one that the scene asks for. Those about the initial
/// state ([`Warning::VesicleAtWall`], [`Warning::TargetOutOfReach`], [`Warning::NoMembrane`]) come from
/// who computes that state.
pub fn warnings(scene: &Scene, edge: Option<f64>) -> Vec<Warning> {
    let mut warnings = Vec::new();
    warnings.extend(thin_interface(scene, edge));
    warnings.extend(adaptive_mesh(scene));
    warnings.extend(scene.table_warnings());
    let end = scene.time.end;
    let late = scene.changes.iter().find(|change| change.at >= end);
    warnings.extend(late.map(|change| Warning::ChangeAfterEnd { at: change.at, end }));
    warnings
}

/// The warning of an interface that spans too few cells, or triangles.
fn thin_interface(scene: &Scene, edge: Option<f64>) -> Option<Warning> {
    let interface_width = scene.membrane.interface_width;
    let is_thin = |spanned: f64| is_fewer(spanned, CELLS_FOR_ENERGIES);
    let (key, wanted) = match scene.mesh {
        Mesh::Structured { cells, .. } => {
            return is_thin(interface_width * cells as f64).then_some(Warning::ThinInterface {
                interface_width,
                cells,
            });
        }
        Mesh::Delaunay { size, refine, .. } => match refine {
            Some(refinement) => (Some("mesh.refine.size"), Some(refinement.size)),
            None => (Some("mesh.size"), Some(size)),
        },
        Mesh::Adaptive { refine, .. } => (Some("mesh.interface"), Some(refine.size)),
        Mesh::File(_) => (None, None),
    };
    let edge = edge.or(wanted)?;
    is_thin(interface_width / edge).then_some(Warning::ThinInterfaceInTriangles {
        interface_width,
        edge,
        key,
    })
}

/// The warnings of a mesh that follows the membrane.
fn adaptive_mesh(scene: &Scene) -> Vec<Warning> {
    let Mesh::Adaptive { refine, .. } = scene.mesh else {
        return Vec::new();
    };
    let (band, interface_width) = (refine.band, scene.membrane.interface_width);
    let mut warnings = Vec::new();
    if is_fewer(band / interface_width, BAND_FOR_INTERFACE) {
        warnings.push(Warning::NarrowBand {
            band,
            interface_width,
        });
    }
    if scene.solver.quadrature == Quadrature::Lumped {
        warnings.push(Warning::LumpedOnAdaptiveMesh);
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Defect, InitialDirector, Time};

    fn scene(interface_width: f64, cells: usize) -> Scene {
        let mut scene = Scene::default();
        scene.membrane.interface_width = interface_width;
        scene.mesh = Mesh::Structured {
            cells,
            jitter: 0.0,
            seed: 1,
        };
        scene
    }

    #[test]
    fn an_interface_of_fewer_than_three_cells_is_told() {
        assert_eq!(warnings(&scene(0.03, 100), None), []);
        assert_eq!(warnings(&scene(0.01, 300), None), []);
        let thin = Warning::ThinInterface {
            interface_width: 0.01,
            cells: 299,
        };
        assert_eq!(warnings(&scene(0.01, 299), None), [thin]);
        let text = warnings(&scene(0.01, 120), None)[0].to_string();
        assert!(
            text.contains("1.20 cells") && text.contains("mesh.cells = 300"),
            "{text}"
        );
        assert!(!text.contains("trusted"), "{text}");
        // Figures that are true whatever the interface spans.
        assert!(
            text.contains("by 83 % where it spans 1.2, 7.5 % at 2.4, 1.9 % at 3.6;"),
            "{text}"
        );
        // The remedy with its price: (300/120)² as many nodes.
        assert!(
            text.ends_with("(6.2 times the nodes and at least the time)"),
            "{text}"
        );
    }

    #[test]
    fn an_adaptive_mesh_that_cannot_hold_the_interface_is_told() {
        let scene = |settings: &[&str]| {
            let mesh = "mesh = { kind = 'adaptive', size = 0.1, interface = 0.003, band = 0.03 }\n\
                        membrane.interface_width = 0.01";
            warnings(&Scene::of_text(mesh, settings), None)
        };
        assert_eq!(scene(&[]), []);
        let narrow = Warning::NarrowBand {
            band: 0.029,
            interface_width: 0.01,
        };
        assert!(narrow.to_string().contains("take 3.00e-2 or more"));
        assert_eq!(scene(&["mesh.band=0.029"]), [narrow]);
        let lumped = scene(&["solver.quadrature=lumped"]);
        assert_eq!(lumped, [Warning::LumpedOnAdaptiveMesh]);
    }

    #[test]
    fn slivers_are_counted_in_words() {
        let text = |count, is_jittered| {
            Warning::Slivers {
                count,
                below: 1.0,
                at: [0.25, 2e-5],
                angles: [3.44e-4, 179.25],
                is_jittered,
            }
            .to_string()
        };
        let one = text(1, true);
        assert!(
            one.starts_with(
                "1 triangle of the mesh has an angle below 1°; the worst, about (0.250, 2.00e-5), has angles \
                 from 3.4e-4° to 179.25°: "
            ) && one.ends_with("lower mesh.jitter"),
            "{one}"
        );
        let two = text(2, false);
        assert!(
            two.starts_with("2 triangles of the mesh have") && two.contains("Mesh.Optimize"),
            "{two}"
        );
    }

    #[test]
    fn of_an_interface_within_a_cell_the_shape_is_not_to_be_trusted() {
        let text = |scene: &Scene, edge| warnings(scene, edge)[0].to_string();
        let grid = text(&scene(0.01, 48), None);
        for words in [
            "0.480 cells",
            "the shape is not to be trusted",
            "mesh.cells = 100 or more",
        ] {
            assert!(grid.contains(words), "{grid}");
        }
        assert!(!text(&scene(0.01, 100), None).contains("trusted"));
        // On other meshes the edges at the membrane count, not the ones that are asked for.
        let mut delaunay = scene(0.01, 4);
        delaunay.mesh = Mesh::Delaunay {
            size: 0.05,
            seed: 1,
            refine: Some(crate::scene::Refinement {
                band: 0.05,
                size: 0.0095,
            }),
        };
        assert!(!text(&delaunay, None).contains("trusted"));
        let coarse = text(&delaunay, Some(0.012));
        for words in [
            "0.833 triangles",
            "edges at the membrane 0.0120",
            "the shape is not to be trusted",
            "mesh.refine.size = 1.00e-2 or less",
        ] {
            assert!(coarse.contains(words), "{coarse}");
        }
        assert!(!text(&delaunay, Some(0.0099)).contains("trusted"));
        delaunay.membrane.interface_width = 1e-7;
        let small = text(&delaunay, Some(1e-6));
        assert!(small.contains("edges at the membrane 1.00e-6"), "{small}");
    }

    #[test]
    fn an_end_between_two_steps_is_reported() {
        let warned = |step, end| {
            let mut scene = scene(0.03, 100);
            scene.time = Time {
                step,
                end,
                ..Time::default()
            };
            warnings(&scene, None)
        };
        for (step, end) in [(1e-7, 1e-3), (0.1, 0.3), (3e-7, 3e-4), (1e-9, 1.0)] {
            assert_eq!(warned(step, end), [], "{step} {end}");
        }
        let text = warned(3e-7, 1e-3)[0].to_string();
        assert!(
            text.contains("takes 3333 steps and ends at t = 9.999e-4"),
            "{text}"
        );
        // It may be --until that says so.
        assert!(text.starts_with("the end, t = 1e-3, is no"), "{text}");
        let text = warned(3e-7, 5e-7)[0].to_string();
        assert!(text.contains("2 steps and ends at t = 6e-7"), "{text}");
        let mut chosen = scene(0.03, 100);
        chosen.time.step = 3e-7;
        chosen.time.tolerance = Some(1e-3);
        assert_eq!(warnings(&chosen, None), []);
    }

    #[test]
    fn a_winding_that_is_no_whole_number_is_reported_with_the_reason() {
        let warned = |at: &[([f64; 2], f64)]| {
            let mut scene = scene(0.03, 100);
            let defect = |&(center, winding)| Defect { center, winding };
            let at = at.iter().map(defect).collect();
            scene.nematic = Some(crate::scene::Nematic {
                initial: InitialDirector::Defects { at, angle: 0.0 },
                ..Default::default()
            });
            let warnings = warnings(&scene, None);
            warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        let (here, there) = ([0.5, 0.5], [0.25, 0.5]);
        assert!(warned(&[(here, 1.0), (there, -2.0)]).is_empty());
        // Two halves in one place are a whole.
        assert!(warned(&[(here, 0.5), (here, 0.5)]).is_empty());
        let halves = warned(&[(here, 0.5), (there, -0.5), ([0.1, 0.1], 1.0)]);
        assert_eq!(halves.len(), 2, "{halves:?}");
        assert!(
            halves[0].contains("turns 0.5 times around (0.5, 0.5)")
                && halves[0].contains("jumps from d to −d"),
            "{halves:?}"
        );
        let third = warned(&[(here, 0.3)]);
        assert!(third[0].contains("to another direction"), "{third:?}");
    }

    #[test]
    fn a_field_that_nothing_withstands_is_told() {
        let mut scene = scene(0.03, 100);
        scene.nematic = Some(crate::scene::Nematic {
            weight: 2.0,
            penalty: 0.1,
            ..Default::default()
        });
        let field = |weight| crate::scene::Field {
            weight,
            strength: 2.0,
            ..Default::default()
        };
        scene.field = Some(field(99.0));
        assert_eq!(warnings(&scene, None), []);
        scene.field = Some(field(100.0));
        let text = warnings(&scene, None)[0].to_string();
        assert!(
            text.contains("= 400 must be below") && text.contains("400.0"),
            "{text}"
        );
        scene.field = Some(field(-1e9));
        assert_eq!(warnings(&scene, None), []);
    }

    #[test]
    fn the_warnings_of_the_shape_give_their_numbers() {
        let reach = |target, quotient, geometry| {
            let warning = Warning::TargetOutOfReach {
                target,
                quotient,
                geometry,
            };
            warning.to_string()
        };
        let text = reach(0.75, 0.69, Geometry::Planar);
        assert!(text.contains("0.5625") && text.contains("0.6900") && text.contains("0.8307"));
        let text = reach(0.7, 0.4096, Geometry::Axisymmetric);
        assert!(text.contains("area.target³") && text.contains("36π·volume²/surface³"));
        assert!(text.contains("0.3430") && text.contains("0.4096") && text.contains("0.7427"));
        let near = Warning::VesicleAtWall {
            distance: 0.02,
            interface_width: 0.01,
        }
        .to_string();
        assert!(near.contains("within 0.020 of the wall"), "{near}");
        let across = Warning::VesicleAtWall {
            distance: -0.1,
            interface_width: 0.01,
        }
        .to_string();
        assert!(across.contains("across the wall (by 0.10)"), "{across}");
        // A domain in metres.
        let small = Warning::VesicleAtWall {
            distance: 1.2e-6,
            interface_width: 1e-6,
        }
        .to_string();
        assert!(
            small.contains("within 1.2e-6 of the wall") && small.contains("about 4.0e-6 wide"),
            "{small}"
        );
        for distance in [0.0, -0.0, 1e-4, -1e-4] {
            let at = Warning::VesicleAtWall {
                distance,
                interface_width: 0.01,
            };
            assert!(at.to_string().contains("touches the wall"), "{at}");
        }
    }
}
