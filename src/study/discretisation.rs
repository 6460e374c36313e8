//! One way to compute a scene: a mesh, steps, quadrature and iteration.

use crate::scene::{InitialDirector, Time, TimeScheme, significant};
use crate::scene::{Iteration, Mesh, Quadrature, Scene, Shape};
use serde::Serialize;
use std::fmt;

/// How long steps are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum StepControl {
    /// Δt, fixed; the paper's scheme, of first order.
    Step(f64),
    /// Chosen by a tolerance; by the secant scheme, or the scene's own.
    Tolerance(f64),
}

impl fmt::Display for StepControl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step(step) => write!(f, "\u{394}t = {step:e}"),
            Self::Tolerance(tolerance) => write!(f, "tolerance {tolerance:e}"),
        }
    }
}

/// What kind of mesh it is, and so what tells how fine it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeshKind {
    /// Cells along each side.
    Structured,
    /// Generated, by the length of its edges: the scene's own, and how many of them lie along a side.
    Generated {
        /// The key: mesh.size, or mesh.interface of a mesh that follows the membrane.
        key: &'static str,
        /// Its value.
        size: f64,
        /// 1/h.
        cells: usize,
    },
    /// That of a file, which has so many nodes.
    File {
        /// How many.
        nodes: usize,
    },
}

impl MeshKind {
    fn of(scene: &Scene) -> Self {
        match &scene.mesh {
            Mesh::Structured { .. } => Self::Structured,
            Mesh::Delaunay { size, .. } => Self::Generated {
                key: "mesh.size",
                size: *size,
                cells: cells_of(*size),
            },
            Mesh::Adaptive { refine, .. } => Self::Generated {
                key: "mesh.interface",
                size: refine.size,
                cells: cells_of(refine.size),
            },
            Mesh::File(file) => Self::File {
                nodes: file.triangulation.nodes.len(),
            },
        }
    }

    /// 1/h of a generated mesh.
    fn cells(self) -> Option<usize> {
        match self {
            Self::Generated { cells, .. } => Some(cells),
            Self::Structured | Self::File { .. } => None,
        }
    }

    /// How fine the mesh with so many cells (1/h) is, in words.
    pub fn words(self, cells: usize) -> String {
        match self {
            Self::Structured => format!("{cells} cells"),
            Self::Generated {
                key,
                size,
                cells: own,
            } => {
                let size = size * own as f64 / cells as f64;
                format!("{key} {}", significant(size, 3))
            }
            Self::File { nodes } => format!("{nodes} nodes"),
        }
    }
}

/// One way to compute a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discretisation {
    /// 1/h.
    pub cells: usize,
    /// What kind of mesh it is on.
    pub mesh: MeshKind,
    /// How long steps are.
    pub pace: StepControl,
    /// The rule of every integral.
    pub quadrature: Quadrature,
    /// The iteration for (3.21).
    pub iteration: Iteration,
}

impl fmt::Display for Discretisation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} and {}", self.mesh.words(self.cells), self.pace)
    }
}

impl Discretisation {
    /// The way that a scene asks for.
    pub fn of(scene: &Scene) -> Self {
        Self {
            cells: fineness(scene),
            mesh: MeshKind::of(scene),
            pace: match scene.time.tolerance {
                None => StepControl::Step(scene.time.step),
                Some(tolerance) => StepControl::Tolerance(tolerance),
            },
            quadrature: scene.solver.quadrature,
            iteration: scene.solver.iteration,
        }
    }

    /// The scene, computed this way.
    pub fn applied_to(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        match &mut scene.mesh {
            Mesh::Structured { cells, .. } => *cells = self.cells,
            mesh => {
                let own = self.mesh.cells().unwrap_or(self.cells);
                if self.cells != own {
                    scale_mesh(mesh, own as f64 / self.cells as f64);
                }
            }
        }
        let end = scene.time.end;
        let scheme = match scene.time.tolerance {
            Some(_) => scene.time.scheme,
            None => TimeScheme::Secant,
        };
        let default = Time::default();
        scene.time = match self.pace {
            StepControl::Step(step) => Time {
                step,
                tolerance: None,
                scheme: TimeScheme::FirstOrder,
                end,
            },
            StepControl::Tolerance(tolerance) => Time {
                step: default.step,
                tolerance: Some(tolerance),
                scheme,
                end,
            },
        };
        scene.solver.quadrature = self.quadrature;
        scene.solver.iteration = self.iteration;
        scene
    }
}

/// Makes the edges of a mesh longer by this factor, everywhere; a grid gets the nearest number of cells. That of a file stays.
pub(super) fn scale_mesh(mesh: &mut Mesh, factor: f64) {
    match mesh {
        Mesh::Structured { cells, .. } => {
            *cells = (*cells as f64 / factor).round().max(1.0) as usize;
        }
        Mesh::Delaunay { size, refine, .. } => {
            *size *= factor;
            if let Some(refinement) = refine {
                refinement.size *= factor;
            }
        }
        Mesh::Adaptive { size, refine, .. } => {
            *size *= factor;
            refine.size *= factor;
        }
        Mesh::File(_) => {}
    }
}

/// Why a scene cannot be computed on another mesh, in words; `None` if it can. It cannot if it has values
/// at the nodes of its own.
pub(super) fn fixed_mesh(scene: &Scene) -> Option<String> {
    if let Some((key, file)) = scene.nodal_files().first() {
        return Some(format!(
            "{} are the values at its nodes ({})",
            file.path, key.name
        ));
    }
    let nematic = scene.nematic.as_ref();
    let is_random = nematic.is_some_and(|it| matches!(it.initial, InitialDirector::Random { .. }));
    match (&scene.vesicle.shape, &scene.mesh) {
        (Shape::Random { .. }, _) => Some("the phase is drawn at random node by node".to_owned()),
        _ if is_random => Some("the director is drawn at random node by node".to_owned()),
        (_, Mesh::File(file)) => Some(format!("it is that of {}", file.path)),
        (_, Mesh::Structured { .. }) if !scene.mesh.is_grid() => {
            Some("its nodes are moved at random (mesh.jitter)".to_owned())
        }
        (_, Mesh::Structured { .. } | Mesh::Delaunay { .. } | Mesh::Adaptive { .. }) => None,
    }
}

/// 1/h: of the structured mesh, of a generated one by its size, of another by its nodes.
fn fineness(scene: &Scene) -> usize {
    match &scene.mesh {
        Mesh::Structured { cells, .. } => *cells,
        Mesh::Delaunay { size, .. } => cells_of(*size),
        Mesh::Adaptive { refine, .. } => cells_of(refine.size),
        Mesh::File(file) => (file.triangulation.nodes.len() as f64).sqrt().round() as usize,
    }
}

/// Edges of this length along a side of the square.
fn cells_of(size: f64) -> usize {
    size.recip().round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_generated_mesh_is_refined_as_a_whole() {
        let text =
            "mesh = { kind = 'delaunay', size = 0.03, refine = { band = 0.1, size = 0.01 } }";
        let scene = Scene::of_text(text, &[]);
        assert_eq!(fixed_mesh(&scene), None);
        let own = Discretisation::of(&scene);
        assert_eq!(
            (own.cells, own.applied_to(&scene).mesh),
            (33, scene.mesh.clone())
        );
        let Mesh::Delaunay { size, refine, .. } = (Discretisation { cells: 66, ..own })
            .applied_to(&scene)
            .mesh
        else {
            panic!("a mesh of another kind");
        };
        let refined = refine.expect("it stays refined");
        let close = |a: f64, b: f64| (a - b).abs() < 1e-15;
        assert!(close(size, 0.015) && close(refined.size, 0.005) && refined.band == 0.1);
        let text = "mesh = { kind = 'adaptive', size = 0.08, interface = 0.01, band = 0.03 }";
        let scene = Scene::of_text(text, &[]);
        let own = Discretisation::of(&scene);
        assert_eq!((own.cells, fixed_mesh(&scene)), (100, None));
        assert_eq!(own.mesh.words(200), "mesh.interface 0.00500");
        let Mesh::Adaptive { size, refine, .. } = (Discretisation { cells: 200, ..own })
            .applied_to(&scene)
            .mesh
        else {
            panic!("a mesh of another kind");
        };
        assert!(close(size, 0.04) && close(refine.size, 0.005) && refine.band == 0.03);
    }

    #[test]
    fn a_mesh_is_told_by_what_it_is_given_by() {
        let scene = |text: &str| {
            let file = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n\
                        $EndNodes\n$Elements\n2\n1 2 0 1 2 3\n2 2 0 1 3 4\n$EndElements\n";
            let mut read = |_: &str| Ok(file.as_bytes().to_vec());
            Scene::parse(text, "a study", &[], &mut read).expect("a scene")
        };
        let of = |text: &str| Discretisation::of(&scene(text));
        let told = |choice: Discretisation| choice.mesh.words(choice.cells);
        assert_eq!(told(of("mesh.cells = 24")), "24 cells");
        let own = of("mesh = { kind = 'delaunay', size = 0.03 }");
        assert_eq!(told(own), "mesh.size 0.0300");
        assert_eq!(
            told(Discretisation { cells: 66, ..own }),
            "mesh.size 0.0150"
        );
        assert_eq!(
            told(of("mesh = { kind = 'file', path = 'a.msh' }")),
            "4 nodes"
        );
    }

    /// Whatever the values are, and nothing else on a grid.
    #[test]
    fn values_at_nodes_keep_their_mesh() {
        for (settings, columns) in [
            ("vesicle = { shape = 'file', values = 'v.txt' }", 1),
            ("membrane.spontaneous_curvature = { file = 'v.txt' }", 1),
            ("nematic.initial = { kind = 'file', values = 'v.txt' }", 2),
            ("pull.potential = { file = 'v.txt' }", 1),
        ] {
            let line = "0.5 ".repeat(columns) + "\n";
            let mut read = |_: &str| Ok(line.repeat(81).into_bytes());
            let text = format!("mesh.cells = 8\n{settings}");
            let scene = Scene::parse(&text, "a study", &[], &mut read).expect("a scene");
            let reason = fixed_mesh(&scene).expect(settings);
            assert!(
                reason.starts_with("v.txt are the values at its nodes"),
                "{reason}"
            );
        }
        let text = "pull.potential = 'x'\n[nematic]\n[area]";
        let scene = Scene::of_text(text, &[]);
        assert_eq!(fixed_mesh(&scene), None);
    }
}
