//! What a run needs before it is begun: memory.

use super::SimulationError;
use super::claim::{self, Claim, Shortage};
use super::free_memory::{FreeMemory, free_memory};
use crate::scene::{Boundary, LinearMethod, Mesh, MeshSize, Quadrature, Scene};

/// Bytes that a run needs on any mesh.
const ANY_RUN: f64 = 9e6;

/// Bytes a node with each quadrature, without a director: fields, matrices, histories.
const LUMPED: f64 = 2640.0;
const CONSISTENT: f64 = 2350.0;

/// Bytes a node more with a director.
const DIRECTOR: f64 = 1050.0;

/// Bytes a node more with the sparse factor, whose entries grow like n log n: these, and so many more
/// for each doubling of the nodes.
const FACTOR: f64 = 3240.0;
const FACTOR_GROWTH: f64 = 250.0;

/// Bytes a node more with two factors of shifted Laplacians, by the same law, and with each further one
/// for each doubling of the nodes: some 29 entries a node at 14,641 nodes, in single precision.
const SHIFTED: f64 = 150.0;
const SHIFTED_GROWTH: f64 = 50.0;
const SHIFTED_FACTOR: f64 = 8.3;

/// The memory that the run of a scene will take from its start, in bytes; where it turns to the sparse
/// factor on the way, more: see `memory_held`.
pub fn memory_needed(scene: &Scene) -> u64 {
    let begins_with_factor = scene.boundary == Boundary::Clamped
        || match scene.solver.linear {
            LinearMethod::Automatic => scene.time.tolerance.is_some(),
            LinearMethod::Factor => true,
            LinearMethod::Transform | LinearMethod::Shifted => false,
        };
    memory_held(scene, begins_with_factor)
}

/// Whether a scene's fast path is that by factors of shifted Laplacians.
fn is_shifted(scene: &Scene) -> bool {
    scene.boundary == Boundary::Natural
        && match scene.solver.linear {
            LinearMethod::Automatic => !scene.mesh.is_grid(),
            LinearMethod::Shifted => true,
            LinearMethod::Transform | LinearMethod::Factor => false,
        }
}

/// The memory that the run of a scene takes, in bytes, with the sparse factor or without. Within 6 % of
/// what case 3 with fixed steps takes at 60, 120, 240 and 400 cells without the factor and at 60, 120 and
/// 240 with it (8 % above with both the factor and lumped quadrature), the largest resident size by
/// `wait4`.
pub fn memory_held(scene: &Scene, with_factor: bool) -> u64 {
    let nodes = node_count(scene);
    let mut per_node = match scene.solver.quadrature {
        Quadrature::Lumped => LUMPED,
        Quadrature::Consistent => CONSISTENT,
    };
    if scene.nematic.is_some() {
        per_node += DIRECTOR;
    }
    if is_shifted(scene) {
        // With chosen steps those of the last one are kept.
        let more_factors = if scene.time.tolerance.is_some() {
            2.0
        } else {
            0.0
        };
        per_node += SHIFTED + (SHIFTED_GROWTH + more_factors * SHIFTED_FACTOR) * nodes.log2();
    }
    if with_factor {
        per_node += FACTOR + FACTOR_GROWTH * nodes.log2();
    }
    // When the mesh is made again, the old one and its matrices are still there.
    let copies = match scene.mesh {
        Mesh::Adaptive { .. } => 2.0,
        _ => 1.0,
    };
    // Saturates.
    (ANY_RUN + copies * per_node * nodes) as u64
}

/// The nodes of a scene's mesh: how many, or about how many where they are still to be scattered.
pub fn node_count(scene: &Scene) -> f64 {
    match &scene.mesh {
        Mesh::Structured { cells, .. } => (*cells as f64 + 1.0).powi(2),
        Mesh::Delaunay { size, refine, .. } => {
            MeshSize::new(*size, *refine, &scene.vesicle.shape).nodes()
        }
        Mesh::Adaptive { size, refine, .. } => {
            MeshSize::at_start(*size, *refine, &scene.vesicle.shape).nodes()
        }
        Mesh::File(file) => file.triangulation.nodes.len() as f64,
    }
}

/// Refuses a scene that needs more memory than there is; nothing is allocated.
///
/// # Errors
/// [`SimulationError::Memory`] with both figures.
pub fn check_memory(scene: &Scene) -> Result<(), SimulationError> {
    refuse(scene, free_memory())
}

fn refuse(scene: &Scene, free: Option<FreeMemory>) -> Result<(), SimulationError> {
    claim::check(memory_needed(scene), free).map_err(|shortage| too_large(scene, shortage))
}

/// Sets aside what a run of the scene needs, for its set-up.
///
/// # Errors
/// [`SimulationError::Memory`]; `Ended` if it was ended while it waited for the claims of others.
pub(super) fn claim_memory(
    scene: &Scene,
    leave: &mut dyn FnMut() -> bool,
) -> Result<Claim, SimulationError> {
    let claim = Claim::unless(memory_needed(scene), leave);
    claim
        .map_err(|shortage| too_large(scene, shortage))?
        .ok_or(SimulationError::Ended)
}

fn too_large(scene: &Scene, shortage: Shortage) -> SimulationError {
    let (mesh, remedy) = match &scene.mesh {
        Mesh::Structured { cells, .. } => (
            format!("of {cells} \u{d7} {cells} cells"),
            "lower mesh.cells",
        ),
        Mesh::Delaunay { .. } => (
            format!("of about {:.0} nodes", node_count(scene)),
            "raise mesh.size",
        ),
        Mesh::Adaptive { .. } => (
            format!("of about {:.0} nodes", node_count(scene)),
            "raise mesh.interface, or the accuracy that it follows from",
        ),
        Mesh::File(file) => (
            format!("of {} nodes", file.triangulation.nodes.len()),
            "take a coarser one",
        ),
    };
    SimulationError::Memory {
        mesh,
        shortage,
        remedy,
    }
}

#[cfg(test)]
mod tests {
    use super::super::free_memory::MemoryBound;
    use super::*;

    fn scene(settings: &[&str]) -> Scene {
        let text = crate::scene::preset("case3").expect("a preset");
        Scene::of_text(text, settings)
    }

    /// Against the measured resident sizes in MB (2²⁰ bytes).
    #[test]
    fn the_estimate_is_what_was_measured() {
        for (settings, measured) in [
            (&["mesh.cells=60"][..], 20.8),
            (&["mesh.cells=120"], 55.6),
            (&["mesh.cells=240"], 191.2),
            (&["mesh.cells=400"], 523.6),
            (&["anchoring=false", "nematic=false"], 40.9),
            (&["solver.quadrature=lumped"], 58.4),
            (&["solver.quadrature=lumped", "mesh.cells=240"], 210.3),
            (&["solver.linear=factor"], 149.2),
            (&["solver.linear=factor", "mesh.cells=240"], 587.1),
            (&["domain.boundary=clamped"], 148.9),
        ] {
            let estimate = memory_needed(&scene(settings)) as f64 / f64::from(1 << 20);
            let ratio = estimate / measured;
            assert!((0.94..1.06).contains(&ratio), "{settings:?}: {estimate}");
        }
    }

    /// About as much as was measured: 12.1 MB (2²⁰ bytes) more than with the transform of the grid.
    #[test]
    fn shifted_laplacians_need_less_than_the_factor() {
        let needed = |settings: &[&str]| memory_needed(&scene(settings)) as f64 / 1e6;
        let more = needed(&["solver.linear=shifted"]) - needed(&[]);
        assert!((11.0..16.0).contains(&more), "{more}");
        assert_eq!(
            needed(&["mesh.jitter=0.1"]),
            needed(&["solver.linear=shifted"])
        );
        assert!(needed(&["solver.linear=factor"]) > needed(&[]) + 4.0 * more);
    }

    #[test]
    fn the_nodes_of_a_generated_mesh_are_known_beforehand() {
        for settings in [
            &["mesh.size=0.05"][..],
            &["mesh.size=0.02"],
            &[
                "mesh.size=0.06",
                "mesh.refine={ band = 0.05, size = 0.015 }",
            ],
        ] {
            let settings = [&["mesh.kind=delaunay"][..], settings].concat();
            let scene = scene(&settings);
            let mesh = crate::fem::Mesh::of(&scene).expect("a mesh");
            let ratio = node_count(&scene) / mesh.nodes().len() as f64;
            assert!((0.9..1.2).contains(&ratio), "{settings:?}: {ratio}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused_with_the_figures() {
        let large = scene(&["mesh.cells=20000"]);
        let free = |bytes| {
            let bound = MemoryBound::Machine;
            Some(FreeMemory { bytes, bound })
        };
        let error = refuse(&large, free(8_000_000_000)).unwrap_err().to_string();
        for part in ["20000", "1360 GB", "8.00 GB", "mesh.cells"] {
            assert!(error.contains(part), "no {part} in {error}");
        }
        assert_eq!(refuse(&large, None), Ok(()));
        for (bound, words) in [
            (MemoryBound::Machine, "2.00 GB of memory are free"),
            (
                MemoryBound::Group,
                "2.00 GB are left of the memory that the container or the job may take",
            ),
            (
                MemoryBound::AddressSpace,
                "2.00 GB are left of the address space that ulimit -v allows",
            ),
            (
                MemoryBound::Data,
                "2.00 GB are left of the data that ulimit -d allows",
            ),
        ] {
            let bytes = 2_000_000_000;
            let error = refuse(&large, Some(FreeMemory { bytes, bound })).unwrap_err();
            assert!(error.to_string().contains(words), "{error}");
        }
        // What is ended at once beyond its bound has some room.
        let within = |bound| {
            let bytes = 11 * (memory_needed(&large) / 10);
            refuse(&large, Some(FreeMemory { bytes, bound }))
        };
        assert!(within(MemoryBound::Group).is_ok() && within(MemoryBound::AddressSpace).is_err());
        let small = scene(&["mesh.cells=8"]);
        assert_eq!(refuse(&small, free(10_000_000)), Ok(()));
        assert!(refuse(&small, free(1_000_000)).is_err());
    }
}
