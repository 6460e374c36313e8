//! The price list of accuracy: a scene with the mesh and the steps for each of a few errors of φ.

use std::sync::Arc;

use super::run_estimate::{Foresight, run_estimate};
use crate::scene::{Mesh, Problem, Scene};
use crate::simulation::{memory_needed, node_count};

/// The errors of φ at the end, in L2.
const ERRORS: [f64; 5] = [1e-1, 3e-2, 1e-2, 3e-3, 1e-3];

/// A line of the list.
#[derive(Debug, Clone, PartialEq)]
pub struct Offer {
    /// The error of φ that mesh and steps are chosen for.
    pub error: f64,
    /// What is offered, or why there is none.
    pub offered: Result<OfferedScene, Problem>,
}

/// A scene with the mesh and the steps for an error.
#[derive(Debug, Clone, PartialEq)]
pub struct OfferedScene {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The edges at the membrane.
    pub edge: f64,
    /// About how many nodes the first mesh has.
    pub nodes: u64,
}

impl Offer {
    /// The list of a scene, the cheapest first.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let offer = |error| Self {
            error,
            offered: scene.with_accuracy(error).map(OfferedScene::new),
        };
        ERRORS.map(offer).into()
    }
}

impl OfferedScene {
    fn new(scene: Scene) -> Self {
        let edge = match scene.mesh {
            Mesh::Adaptive { refine, .. } => refine.size,
            _ => f64::NAN,
        };
        Self {
            edge,
            // The cast saturates.
            nodes: node_count(&scene) as u64,
            scene: Arc::new(scene),
        }
    }
}

/// What the run of a scene would take on this machine, in words, or why it cannot be run. `None`: `go_on` was false.
pub fn price_words(
    scene: &Scene,
    go_on: &mut dyn FnMut() -> bool,
) -> Option<Result<String, String>> {
    Some(match run_estimate(scene, go_on) {
        Ok(Foresight::Price(price)) => Ok(format!("{price}{}", reservations(scene))),
        Ok(Foresight::TooLarge(nodes)) => Ok(format!(
            "{:.1} GB; how long is not tried with {nodes} nodes",
            memory_needed(scene) as f64 / 1e9
        )),
        Ok(Foresight::Unsolved(unsolved)) => Ok(format!("more than can be foreseen: {unsolved}")),
        Ok(Foresight::Ended) => return None,
        Err(error) => Err(format!("it cannot be run: {error}")),
    })
}

/// What there is to know of a price, and of what is had for it.
pub fn reservations(scene: &Scene) -> String {
    let mut words = String::new();
    if scene.rest.is_some() {
        words += "; less where it comes to rest before";
    }
    if let Mesh::Adaptive { refine, .. } = scene.mesh
        && refine.size > scene.membrane.interface_width
    {
        words += "; too coarse for shapes";
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{NodalValues, ScalarField};

    #[test]
    fn smaller_errors_need_more_nodes_and_what_cannot_be_had_says_why() {
        let text = crate::scene::preset("case3").expect("a preset");
        let offers = Offer::all(&Scene::of_text(text, &[]));
        let nodes = offers
            .iter()
            .map(|it| it.offered.as_ref().expect("one").nodes);
        let nodes: Vec<u64> = nodes.collect();
        assert!(nodes.is_sorted() && nodes[4] > 4 * nodes[0], "{nodes:?}");
        // As the warnings of their runs have it.
        for offer in &offers {
            let scene = &offer.offered.as_ref().expect("one").scene;
            let warned = crate::scene::warnings(scene, None);
            let is_warned = warned
                .iter()
                .any(|it| it.to_string().contains("the shape is not to be trusted"));
            assert_eq!(
                reservations(scene).contains("too coarse"),
                is_warned,
                "{:e}",
                offer.error
            );
        }
        let rests = Scene::of_text("[rest]", &[]);
        assert!(reservations(&rests).contains("comes to rest"));
        let edges = offers
            .iter()
            .map(|it| it.offered.as_ref().expect("one").edge);
        assert!(edges.rev().is_sorted());
        // Nodal values belong to the mesh that they were made for.
        let mut nodal =
            Scene::of_text(text, &["vesicle={ shape='random', amplitude=0.1, seed=1 }"]);
        assert!(Offer::all(&nodal).iter().all(|it| it.offered.is_ok()));
        let values = NodalValues {
            path: "k.txt".to_owned(),
            values: vec![0.0; 14_641].into(),
            columns: 1,
        };
        nodal.membrane.spontaneous_curvature = ScalarField::File(values);
        for offer in Offer::all(&nodal) {
            assert!(
                offer
                    .offered
                    .is_err_and(|why| why.to_string().contains("k.txt"))
            );
        }
    }
}
