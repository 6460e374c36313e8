//! One number in place of mesh and steps: `accuracy`, the error of φ that is wanted at the end, in L2.
//!
//! Half of it is left to the mesh and half to the steps. With edges h at the membrane the error of the mesh was found to be
//! about 1.2e-2 (h/ε)³, and that of the steps about `time.tolerance`, in cases 3 and 4 (docs/guide/accuracy.md has the
//! measurements, and what other scenes have).

use super::error::{Problem, SceneError};
use super::reader::{Bound, Field, Reader};
use super::tables::{LONGEST_EDGE, Mesh, Refinement, SHORTEST_EDGE, Scene, TimeScheme};

const WANTED: Bound = Bound::new("a finite number > 0, such as 1e-2", |v| v > 0.0);

/// The error of the mesh over (h/ε)³.
const OF_MESH: f64 = 1.2e-2;

/// The error of the steps over `time.tolerance`.
const OF_STEPS: f64 = 1.0;

/// Edges at the membrane, over ε: with longer ones the interface, which is some 4 ε wide, has fewer than two.
pub(crate) const LONGEST_OVER_WIDTH: f64 = 2.0;

/// The band of fine edges on either side of the membrane, over ε.
const BAND: f64 = 3.0;

/// Edges far from the membrane.
const FAR: f64 = 0.08;

/// What a scene asks for.
pub(super) struct Wanted<'a> {
    field: Field<'a>,
    error: f64,
}

impl<'a> Wanted<'a> {
    /// The accuracy that a document asks for, and the document without the mesh that it takes the place of.
    pub(super) fn read(top: &mut Reader<'a>) -> Result<Option<Self>, SceneError> {
        let Some(field) = top.get("accuracy") else {
            return Ok(None);
        };
        let error = field.number(WANTED)?;
        if let Some(mesh) = top.present("mesh")? {
            let is_file = mesh
                .get("kind")
                .is_some_and(|kind| kind.text() == Ok("file"));
            for (_, other) in mesh.fields() {
                if is_file || !field.is_override() || other.is_override() {
                    return Err(other.key_error(Problem::AccuracyAndMesh));
                }
            }
        }
        if let Some(time) = top.present("time")? {
            for key in ["step", "tolerance", "scheme"] {
                if let Some(other) = time.get(key)
                    && (!field.is_override() || other.is_override())
                {
                    return Err(other.key_error(Problem::AccuracyAndSteps));
                }
            }
        }
        top.pass_over("mesh");
        Ok(Some(Self { field, error }))
    }

    /// Gives a scene the mesh and the steps for it.
    pub(super) fn give(&self, scene: &mut Scene) -> Result<(), SceneError> {
        choose(scene, self.error).map_err(|problem| self.field.error(problem))
    }
}

impl Scene {
    /// The scene with the mesh and the steps for an error of φ, in place of its own.
    ///
    /// # Errors
    /// `Problem`: its data belong to its own mesh, or with that error there would be no interface, or edges shorter than any mesh has.
    pub fn with_accuracy(&self, error: f64) -> Result<Self, Problem> {
        if matches!(self.mesh, Mesh::File(_)) {
            return Err(Problem::AccuracyAndMesh);
        }
        let mut scene = self.clone();
        choose(&mut scene, error)?;
        scene.name = format!("{}, error {error:e}", self.name);
        Ok(scene)
    }
}

/// Gives a scene the mesh and the steps for an error of φ.
fn choose(scene: &mut Scene, error: f64) -> Result<(), Problem> {
    if let Some((key, file)) = scene.nodal_files().first() {
        return Err(Problem::NodalValuesOnAdaptiveMesh {
            key: key.name.to_owned(),
            path: file.path.clone(),
        });
    }
    let width = scene.membrane.interface_width;
    let edge = (0.5 * error / OF_MESH).cbrt();
    if edge > LONGEST_OVER_WIDTH {
        return Err(Problem::AccuracyTooLow {
            largest: 2.0 * OF_MESH * LONGEST_OVER_WIDTH.powi(3),
        });
    }
    let size = rounded((edge * width).min(LONGEST_EDGE));
    if size < SHORTEST_EDGE {
        return Err(Problem::AccuracyTooHigh {
            edge: SHORTEST_EDGE,
            least: 2.0 * OF_MESH * (SHORTEST_EDGE / width).powi(3),
        });
    }
    scene.mesh = Mesh::Adaptive {
        size: FAR.max(size),
        refine: Refinement {
            band: rounded(BAND * width),
            size,
        },
        seed: 1,
    };
    scene.time.tolerance = Some(rounded(0.5 * error / OF_STEPS));
    scene.time.scheme = TimeScheme::Secant;
    Ok(())
}

/// To three digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, settings: &[&str]) -> Result<Scene, SceneError> {
        let settings: Vec<String> = settings.iter().map(|it| (*it).to_owned()).collect();
        let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
        Scene::parse(text, "a.toml", &settings, &mut no_files)
    }

    fn edge_and_tolerance(scene: &Scene) -> (f64, Option<f64>) {
        let Mesh::Adaptive { refine, .. } = scene.mesh else {
            panic!("{:?}", scene.mesh);
        };
        (refine.size, scene.time.tolerance)
    }

    #[test]
    fn mesh_and_steps_follow_from_one_number() {
        let text = "accuracy = 1e-2\nmembrane.interface_width = 0.02\ntime.end = 1e-4";
        let scene = read(text, &[]).expect("a scene");
        // 1.2e-2 (h/ε)³ = 5e-3.
        assert_eq!(edge_and_tolerance(&scene), (0.0149, Some(5e-3)));
        assert_eq!(scene.time.end, 1e-4);
        // The scene that is written says mesh and steps, and needs no calibration of a later version.
        let written = scene.to_toml();
        assert!(!written.contains("accuracy"), "{written}");
        assert_eq!(read(&written, &[]).as_ref(), Ok(&scene));
        // Of a scene that is there the same is made.
        let own = read("membrane.interface_width = 0.02\ntime.end = 1e-4", &[]).expect("a scene");
        let mut chosen = own.with_accuracy(1e-2).expect("a scene");
        assert_eq!(chosen.name, format!("{}, error 1e-2", own.name));
        chosen.name = own.name.clone();
        assert_eq!(chosen, scene);
        assert!(matches!(
            own.with_accuracy(0.2),
            Err(Problem::AccuracyTooLow { .. })
        ));
        let finer = read(text, &["accuracy=1e-3"]).expect("a scene");
        let (edge, tolerance) = edge_and_tolerance(&finer);
        assert!(edge < 0.5 * 0.0149 && tolerance == Some(5e-4));
    }

    #[test]
    fn an_override_takes_the_place_of_mesh_and_steps() {
        let text = "mesh.cells = 120\ntime.step = 1e-7\ntime.scheme = 'first-order'";
        let scene = read(text, &["accuracy=1e-2"]).expect("a scene");
        assert_eq!(edge_and_tolerance(&scene), (0.00747, Some(5e-3)));
        assert_eq!(scene.time.scheme, TimeScheme::Secant);
    }

    #[test]
    fn what_contradicts_it_or_cannot_be_had_is_refused() {
        let file = "mesh = { kind = 'file', path = 'a.msh' }";
        let nodal = "vesicle = { shape = 'file', values = 'phi.txt' }";
        for (text, settings, words) in [
            (
                "accuracy = 1e-2\nmesh.cells = 60",
                &[][..],
                "a.toml:2:6: accuracy has a mesh",
            ),
            (
                "accuracy = 1e-2\ntime.step = 1e-7",
                &[],
                "a.toml:2:6: accuracy has the steps",
            ),
            (
                "",
                &["accuracy=1e-2", "time.tolerance=1e-3"],
                "--set time.tolerance=1e-3: accuracy has",
            ),
            (
                "",
                &["accuracy=1e-2", "mesh.cells=60"],
                "--set mesh.cells=60: accuracy has",
            ),
            (file, &["accuracy=1e-2"], "a.toml:1:10: accuracy has a mesh"),
            (nodal, &["accuracy=1e-2"], ""),
            (
                "accuracy = 0",
                &[],
                "a.toml:1:12: accuracy must be a finite number > 0",
            ),
            ("accuracy = nan", &[], "a.toml:1:12: accuracy must be"),
            (
                "accuracy = 0.2",
                &[],
                "a.toml:1:12: the interface would have fewer than two edges",
            ),
            (
                "accuracy = 1e-30",
                &[],
                "a.toml:1:12: the mesh would have edges shorter than 0.00005: the least error that can be had is \
                 accuracy = 3.0e-9",
            ),
        ] {
            let error = read(text, settings).expect_err(text).to_string();
            assert!(error.starts_with(words), "{error}");
        }
    }
}
