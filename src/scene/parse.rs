//! From TOML to a [`Scene`].

use super::accuracy::Wanted;
use super::document;
use super::error::SceneError;
use super::nodal_file::{Context, ReadFile};
use super::reader::{Field, Reader};
use super::tables::{Mesh, Scene, tables};

impl Scene {
    /// Reads a scene.
    ///
    /// - `text` is TOML with the tables and keys of docs/guide/scenes.md; `origin` names it in messages: the
    ///   file's name, or `preset case3`.
    /// - `overrides` are arguments `KEY=VALUE`, applied in their order before anything is checked.
    ///   KEY is dotted, VALUE is TOML or a bare word. A key of a table that is not there makes the
    ///   table; `area=false`, `nematic=false` and so on remove that of an effect; a `vesicle.shape`
    ///   or `vesicle.parts` takes the place of the whole shape in `text`.
    /// - `read` gives the contents of a file of nodal values or of a mesh, by its path as the scene
    ///   gives it.
    ///
    /// # Errors
    ///
    /// Whatever is not TOML, not known, of the wrong type or without sense, with its place.
    pub fn parse<'a>(
        text: &str,
        origin: &str,
        overrides: &[String],
        read: &'a mut ReadFile<'a>,
    ) -> Result<Self, SceneError> {
        let (sources, node) = document::read(text, origin, overrides)?;
        let mut top = Reader::top(&sources, &node);
        let names = tables().into_iter().map(|table| table.name);
        let keys: Vec<&str> = ["name", "accuracy"]
            .into_iter()
            .chain(names)
            .chain(["change"])
            .collect();
        top.allow(&keys)?;
        let accuracy = Wanted::read(&mut top)?;
        let name = top.get("name");
        let name = name.map_or(Ok(Self::default().name), |field| read_name(&field))?;
        let context = Context {
            read,
            mesh: Mesh::default(),
        };
        let mut scene = Self::read(name, &top, context)?;
        if let Some(accuracy) = accuracy {
            accuracy.give(&mut scene)?;
        }
        Ok(scene)
    }
}

fn read_name(field: &Field<'_>) -> Result<String, SceneError> {
    let name = field.text()?;
    if name.trim().is_empty() || name.contains(char::is_control) {
        return Err(field.out_of_range("one line of text"));
    }
    Ok(name.to_owned())
}
