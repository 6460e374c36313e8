//! `scene.toml` and `inputs/`: what was simulated, complete and on its own.

use super::atomic::write_whole;
use super::folder::{SCENE, make};
use super::{Number, RecordError};
use crate::scene::{Mesh, NodalValues, Scene, write_mesh};
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The folder, within a run's, of nodal values that the scene had from files.
pub(super) const INPUTS: &str = "inputs";

/// The name that a mesh from a file has there.
pub(super) const MESH_NAME: &str = "mesh.msh";

/// Writes the scene into a run's folder, with its nodal values beside it, so that the run can be
/// repeated from the folder alone.
///
/// The values are those that are simulated, written again: the files that they came from may have
/// changed since.
///
/// # Errors
/// [`RecordError`] with the file or folder that could not be written.
pub(crate) fn write_scene(folder: &Path, scene: &Scene) -> Result<(), RecordError> {
    let mut scene = scene.clone();
    for (key, nodal) in scene.nodal_files_mut() {
        let inputs = make_inputs(folder)?;
        let name = key.file_name;
        write_whole(&inputs.join(name), |file| write_values(file, nodal))?;
        nodal.path = format!("{INPUTS}/{name}");
    }
    if let Mesh::File(file) = &mut scene.mesh {
        let inputs = make_inputs(folder)?;
        write_whole(&inputs.join(MESH_NAME), |to| {
            write_mesh(to, &file.triangulation)
        })?;
        file.path = format!("{INPUTS}/{MESH_NAME}");
    }
    let text = scene.to_toml();
    write_whole(&folder.join(SCENE), |file| file.write_all(text.as_bytes()))
}

/// The folder of inputs, made if it is not there.
fn make_inputs(folder: &Path) -> Result<PathBuf, RecordError> {
    let inputs = folder.join(INPUTS);
    make(&inputs)?;
    Ok(inputs)
}

/// A text by which the scene of a run is known again: complete but for its end, which may be moved, with
/// a checksum for the nodal values that are files.
pub(crate) fn identity(scene: &Scene) -> String {
    let mut scene = scene.clone();
    scene.time.end = 1.0;
    let mut checksums = String::new();
    for (key, nodal) in scene.nodal_files_mut() {
        nodal.path = format!("{INPUTS}/{}", key.file_name);
        let mut checksum = crc32fast::Hasher::new();
        for value in nodal.values.iter() {
            checksum.update(&value.to_le_bytes());
        }
        let count = nodal.values.len();
        // Writing to a String cannot fail.
        let _ = writeln!(
            checksums,
            "# {}: {count} values, checksum {:08x}",
            nodal.path,
            checksum.finalize()
        );
    }
    if let Mesh::File(file) = &mut scene.mesh {
        file.path = format!("{INPUTS}/{MESH_NAME}");
        let mesh = &file.triangulation;
        let mut checksum = crc32fast::Hasher::new();
        for value in mesh.nodes.iter().flat_map(|node| node.iter()) {
            checksum.update(&value.to_le_bytes());
        }
        for node in mesh.triangles.iter().flatten() {
            checksum.update(&node.to_le_bytes());
        }
        let (count, checksum) = (mesh.nodes.len(), checksum.finalize());
        let path = &file.path;
        let _ = writeln!(
            checksums,
            "# {path}: {count} nodes, checksum {checksum:08x}"
        );
    }
    scene.to_toml() + &checksums
}

/// Whether a run of one scene can be resumed as one of the other: they are the same but for their end.
pub fn same_run(one: &Scene, other: &Scene) -> bool {
    identity(one) == identity(other)
}

/// One node a line, its values separated by a space.
fn write_values(file: &mut dyn Write, nodal: &NodalValues) -> io::Result<()> {
    for node in nodal.values.chunks(nodal.columns.max(1)) {
        for (column, &value) in node.iter().enumerate() {
            let space = if column == 0 { "" } else { " " };
            write!(file, "{space}{}", Number(value))?;
        }
        writeln!(file)?;
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::fs;

    /// A small scene, with `extra` TOML at its end.
    pub fn scene(extra: &str) -> Scene {
        let text = format!(
            "name = \"Small\"\n[mesh]\ncells = 8\n[time]\nstep = 1e-7\nend = 3e-7\n\
             [membrane]\ninterface_width = 0.05\n{extra}"
        );
        Scene::parse(&text, "small.toml", &[], &mut |path| fs::read(path))
            .expect("the scene is right")
    }

    #[test]
    fn the_folder_reads_back_as_the_scene() {
        let folder = tempfile::tempdir().unwrap();
        let scene = scene("");
        write_scene(folder.path(), &scene).unwrap();
        let text = fs::read_to_string(folder.path().join("scene.toml")).unwrap();
        let again = Scene::parse(&text, "scene.toml", &[], &mut |_| unreachable!()).unwrap();
        assert_eq!(again, scene);
        assert!(!folder.path().join(INPUTS).exists());
    }

    #[test]
    fn nodal_values_go_along_and_read_back_exactly() {
        let elsewhere = tempfile::tempdir().unwrap();
        let file = elsewhere.path().join("my values.txt");
        let text: String = (0..81)
            .map(|n| format!("{:?}\n", f64::from(n) / 81.0 - 0.5))
            .collect();
        fs::write(&file, text).unwrap();
        let mut scene = scene(&format!(
            "[vesicle]\nshape = \"file\"\nvalues = '{}'\n",
            file.display()
        ));
        drop(elsewhere);
        let folder = tempfile::tempdir().unwrap();
        write_scene(folder.path(), &scene).unwrap();

        let text = fs::read_to_string(folder.path().join("scene.toml")).unwrap();
        let again = Scene::parse(&text, "scene.toml", &[], &mut |path| {
            fs::read(folder.path().join(path))
        })
        .unwrap();
        let mut files = scene.nodal_files_mut();
        assert_eq!(files.len(), 1);
        files[0].1.path = "inputs/vesicle.txt".into();
        assert_eq!(again, scene);
    }

    #[test]
    fn two_columns_are_two_numbers_a_line() {
        let nodal = NodalValues {
            path: String::new(),
            values: [0.1, 1.0, -1e-7, 3.0].into(),
            columns: 2,
        };
        let mut file = Vec::new();
        write_values(&mut file, &nodal).unwrap();
        assert_eq!(file, b"0.1 1\n-1e-7 3\n");
    }
}
