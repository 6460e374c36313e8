//! A stand-in for the reading and the writing of scenes.

use super::*;
use std::fmt;

/// Something odd in a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning(pub String);
impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}
/// Something wrong in a scene.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct SceneError(String);

const NAMES: [&str; 4] = ["case1", "case2", "case3", "case4"];
const TEXT: &str =
    "name = \"Case\"\n[mesh]\ncells = 120\n[time]\nstep = 1e-7\nend = 1e-3\n[nematic]\n[area]\n";

/// The preset's text.
pub fn preset(name: &str) -> Option<&'static str> {
    NAMES.contains(&name).then_some(TEXT)
}
/// All presets.
pub fn preset_names() -> impl Iterator<Item = &'static str> {
    NAMES.into_iter()
}

/// There is no such preset.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no preset '{name}'; did you mean 'case3'? Presets: case1, case2, case3, case4")]
pub struct UnknownPreset {
    name: String,
}
/// The preset's text.
pub fn find_preset(name: &str) -> Result<&'static str, UnknownPreset> {
    preset(name).ok_or_else(|| UnknownPreset {
        name: name.to_owned(),
    })
}
/// One line about it.
pub fn preset_description(_name: &str) -> Option<&'static str> {
    Some("The paper's case")
}
/// What is odd.
pub fn warnings(_scene: &Scene) -> Vec<Warning> {
    Vec::new()
}

impl Scene {
    /// Reads a scene.
    pub fn parse(
        text: &str,
        origin: &str,
        overrides: &[String],
        read: &mut dyn FnMut(&str) -> std::io::Result<String>,
    ) -> Result<Scene, SceneError> {
        let fail = |e: &dyn fmt::Display| SceneError(format!("{origin}: {e}"));
        let mut table: toml::Table = toml::from_str(text).map_err(|e| fail(&e))?;
        for item in overrides {
            let (key, value) = item.split_once('=').ok_or_else(|| fail(item))?;
            let (outer, inner) = key.split_once('.').ok_or_else(|| fail(item))?;
            let one: toml::Table = toml::from_str(&format!("v = {value}")).map_err(|e| fail(&e))?;
            table
                .entry(outer)
                .or_insert(toml::Table::new().into())
                .as_table_mut()
                .ok_or_else(|| fail(item))?
                .insert(inner.to_owned(), one["v"].clone());
        }
        for key in table.keys() {
            if !["name", "mesh", "time", "vesicle", "nematic", "area"].contains(&key.as_str()) {
                return Err(fail(&format!("unknown key {key}")));
            }
        }
        let number = |outer: &str, inner: &str, default: f64| {
            table
                .get(outer)
                .and_then(|t| t.get(inner))
                .and_then(|v| v.as_float().or(v.as_integer().map(|i| i as f64)))
                .unwrap_or(default)
        };
        let time = Time {
            step: number("time", "step", 1e-7),
            end: number("time", "end", 1e-3),
        };
        if time.end <= 0.0 {
            return Err(fail(&"time.end must be positive"));
        }
        let shape = match table.get("vesicle").and_then(|t| t.get("values")) {
            Some(path) => {
                let path = path.as_str().unwrap_or_default().to_owned();
                let content = read(&path).map_err(|e| fail(&format!("{path}: {e}")))?;
                let values = content.lines().filter_map(|l| l.parse().ok()).collect();
                Shape::File(NodalValues {
                    path,
                    values,
                    columns: 1,
                })
            }
            None => Shape::Random {
                amplitude: 0.5,
                seed: 1,
            },
        };
        Ok(Scene {
            name: table
                .get("name")
                .and_then(|n| n.as_str())
                .unwrap_or("scene")
                .to_owned(),
            boundary: Boundary::Natural,
            mesh: Mesh::Structured {
                cells: number("mesh", "cells", 120.0) as usize,
                jitter: 0.0,
                seed: 0,
            },
            vesicle: Vesicle {
                shape,
                projection: Projection::Nodal,
                scale: number("vesicle", "scale", 1.0),
            },
            time,
            membrane: Membrane {
                interface_width: 0.01,
                mobility: 0.01,
                spontaneous_curvature: ScalarField::Constant(0.0),
            },
            area: table.get("area").map(|_| Area {
                target: 1.25,
                penalty: 1e-3,
            }),
            nematic: table.get("nematic").map(|_| Nematic {
                weight: 10.1,
                mobility: 0.5,
                penalty: 0.075,
                initial: InitialDirector::Uniform([0.0, 1.0]),
            }),
            anchoring: None,
            solver: Solver {
                quadrature: Quadrature::Consistent,
                iteration: Iteration::Newton,
                linear: LinearMethod::Automatic,
                tolerance: 1e-5,
                law_tolerance: 1e-8,
            },
        })
    }

    /// Writes a scene.
    pub fn to_toml(&self) -> String {
        let Mesh::Structured { cells, .. } = self.mesh;
        let mut text = format!(
            "name = {:?}\n[mesh]\ncells = {cells}\n[time]\nstep = {:?}\nend = {:?}\n[vesicle]\nscale = {:?}\n",
            self.name, self.time.step, self.time.end, self.vesicle.scale
        );
        if let Shape::File(values) = &self.vesicle.shape {
            text.push_str(&format!("values = {:?}\n", values.path));
        }
        if self.area.is_some() {
            text.push_str("[area]\n");
        }
        if self.nematic.is_some() {
            text.push_str("[nematic]\n");
        }
        text
    }
}
