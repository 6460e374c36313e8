//! What is allowed in a scene but probably not meant.

use std::fmt;

use super::model::{Mesh, Scene};

/// Cells that an interface of width ε should span.
const CELLS_PER_INTERFACE: f64 = 3.0;

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
        /// The length of an edge at the membrane.
        edge: f64,
        /// The key by which it is made smaller; none where the mesh is from a file.
        key: Option<&'static str>,
    },
    /// The vesicle touches or crosses ∂Ω.
    VesicleAtWall {
        /// The smallest distance from the membrane (φ⁰ = 0) to ∂Ω; ≤ 0 where it crosses it.
        distance: f64,
        /// ε.
        interface_width: f64,
    },
    /// By the isoperimetric inequality no shape of this volume has the surface area β: volume is
    /// conserved, so β²/B(φ⁰)² ≥ 4π·area/length² of the initial shape.
    TargetOutOfReach {
        /// (β/B(φ⁰))², the square of `area.target`.
        target_squared: f64,
        /// 4π·area/length² of the initial shape.
        bound: f64,
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
            } => write!(
                f,
                "the interface spans {:.2} cells of the mesh (membrane.interface_width · mesh.cells \
                 = {interface_width} · {cells}), fewer than {CELLS_PER_INTERFACE}: the law of energy \
                 holds, but the bending energy is too high, by 50 to 100 % at 1.2 cells (by more with \
                 lumped quadrature); for accurate energies take mesh.cells = {} or more",
                interface_width * cells as f64,
                (CELLS_PER_INTERFACE / interface_width).ceil(),
            ),
            Self::ThinInterfaceInTriangles {
                interface_width,
                edge,
                key,
            } => {
                write!(
                    f,
                    "the interface spans {:.2} triangles of the mesh (membrane.interface_width = \
                     {interface_width}, edges at the membrane {edge:.4}), fewer than \
                     {CELLS_PER_INTERFACE}: the law of energy holds, but the bending energy is too \
                     high, by some 50 % at 1.2 (by more with lumped quadrature); for accurate energies ",
                    interface_width / edge,
                )?;
                let enough = interface_width / CELLS_PER_INTERFACE;
                match key {
                    Some(key) => write!(f, "take {key} = {enough:.2e} or less"),
                    None => write!(f, "take a mesh with edges of {enough:.2e} there"),
                }
            }
            Self::VesicleAtWall {
                distance,
                interface_width,
            } => {
                if distance.abs() < 5e-4 {
                    f.write_str("the membrane touches the wall")?;
                } else if distance > 0.0 {
                    write!(f, "the membrane comes within {distance:.3} of the wall")?;
                } else {
                    write!(
                        f,
                        "the vesicle reaches across the wall (by {:.3})",
                        -distance
                    )?;
                }
                write!(
                    f,
                    ", and its interface is about {:.3} wide (4 · membrane.interface_width): the \
                     wall takes part in what happens; move the vesicle (vesicle.center) or make it \
                     smaller",
                    4.0 * interface_width,
                )
            }
            Self::FieldTooStrong { pull, bound } => write!(
                f,
                "the field draws the director out without end: field.weight · field.strength² = \
                 {pull} must be below 2 · nematic.weight/nematic.penalty² = {bound:.6}, or nothing \
                 keeps |d| near 1",
            ),
            Self::TargetOutOfReach {
                target_squared,
                bound,
            } => write!(
                f,
                "the area can never reach its target: the volume is conserved, so area.target² \
                 must be at least 4π·area/length² of the initial shape = {bound:.4} (isoperimetric \
                 inequality), and it is {target_squared:.4}; the smallest target within reach is \
                 {:.4}",
                bound.sqrt(),
            ),
        }
    }
}

/// The warnings that need no more than the scene's numbers. Those about the initial shape
/// ([`Warning::VesicleAtWall`], [`Warning::TargetOutOfReach`]) come from who computes that shape.
pub fn warnings(scene: &Scene) -> Vec<Warning> {
    let interface_width = scene.membrane.interface_width;
    let mut warnings = Vec::new();
    match scene.mesh {
        Mesh::Structured { cells, .. } => {
            // Rounding must not warn of 0.03 · 100 cells.
            let spanned = interface_width * cells as f64 * (1.0 + f64::EPSILON);
            if spanned < CELLS_PER_INTERFACE {
                warnings.push(Warning::ThinInterface {
                    interface_width,
                    cells,
                });
            }
        }
        Mesh::Delaunay { size, refine, .. } => {
            let (key, edge) = match refine {
                Some(refinement) => ("mesh.refine.size", refinement.size),
                None => ("mesh.size", size),
            };
            warnings.extend(thin_interface(interface_width, edge, Some(key)));
        }
        // What its triangles are at the membrane is told when φ⁰ is known.
        Mesh::File(_) => {}
    }
    if let (Some(field), Some(nematic)) = (scene.field, &scene.nematic) {
        let pull = field.weight * field.strength * field.strength;
        let bound = 2.0 * nematic.weight / (nematic.penalty * nematic.penalty);
        if pull >= bound {
            warnings.push(Warning::FieldTooStrong { pull, bound });
        }
    }
    warnings
}

/// The warning of an interface that spans too few triangles, whose edges at the membrane have this
/// length; `key` is what makes them smaller.
pub fn thin_interface(
    interface_width: f64,
    edge: f64,
    key: Option<&'static str>,
) -> Option<Warning> {
    let spanned = interface_width / edge * (1.0 + f64::EPSILON);
    (spanned < CELLS_PER_INTERFACE).then_some(Warning::ThinInterfaceInTriangles {
        interface_width,
        edge,
        key,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(warnings(&scene(0.03, 100)), []);
        assert_eq!(warnings(&scene(0.01, 300)), []);
        let thin = Warning::ThinInterface {
            interface_width: 0.01,
            cells: 299,
        };
        assert_eq!(warnings(&scene(0.01, 299)), [thin]);
        let text = warnings(&scene(0.01, 120))[0].to_string();
        assert!(
            text.contains("1.20 cells") && text.contains("mesh.cells = 300"),
            "{text}"
        );
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
        assert_eq!(warnings(&scene), []);
        scene.field = Some(field(100.0));
        let text = warnings(&scene)[0].to_string();
        assert!(
            text.contains("= 400 must be below") && text.contains("400.0"),
            "{text}"
        );
        scene.field = Some(field(-1e9));
        assert_eq!(warnings(&scene), []);
    }

    #[test]
    fn the_warnings_of_the_shape_give_their_numbers() {
        let reach = Warning::TargetOutOfReach {
            target_squared: 0.5625,
            bound: 0.69,
        };
        let text = reach.to_string();
        assert!(text.contains("0.5625") && text.contains("0.6900") && text.contains("0.8307"));
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
        assert!(across.contains("across the wall (by 0.100)"), "{across}");
        for distance in [0.0, -0.0, 1e-4, -1e-4] {
            let at = Warning::VesicleAtWall {
                distance,
                interface_width: 0.01,
            };
            assert!(at.to_string().contains("touches the wall"), "{at}");
        }
    }
}
