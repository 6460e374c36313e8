//! A [`Scene`] as TOML, complete: every key, defaults too, so that it reads back as the same scene.

use std::fmt::Display;

use super::keywords::{
    ANCHORINGS, BOUNDARIES, ITERATIONS, LINEAR_METHODS, PROJECTIONS, QUADRATURES, name_of,
};
use super::model::{
    Curve, InitialDirector, Mesh, NodalValues, Outline, Refinement, ScalarField, Scene, Shape,
    Vesicle,
};

impl Scene {
    /// The scene as TOML, complete with defaults. [`Scene::parse`] reads it back as an equal scene.
    pub fn to_toml(&self) -> String {
        let mut out = Writer(String::new());
        out.key("name", quoted(&self.name));

        out.table("domain");
        out.key("boundary", quoted(name_of(BOUNDARIES, self.boundary)));

        self.mesh.write(&mut out);

        self.vesicle.write(&mut out);

        out.table("time");
        match self.time.tolerance {
            None => out.key("step", number(self.time.step)),
            Some(tolerance) => out.key("tolerance", number(tolerance)),
        }
        out.key("order", self.time.order.number());
        out.key("end", number(self.time.end));

        out.table("membrane");
        out.key("interface_width", number(self.membrane.interface_width));
        out.key("mobility", number(self.membrane.mobility));
        out.key(
            "spontaneous_curvature",
            scalar_field(&self.membrane.spontaneous_curvature),
        );

        if let Some(area) = &self.area {
            out.table("area");
            out.key("target", number(area.target));
            out.key("penalty", number(area.penalty));
        }
        if let Some(nematic) = &self.nematic {
            out.table("nematic");
            out.key("weight", number(nematic.weight));
            out.key("mobility", number(nematic.mobility));
            out.key("penalty", number(nematic.penalty));
            out.key("initial", initial_director(&nematic.initial));
        }
        if let Some(anchoring) = &self.anchoring {
            out.table("anchoring");
            out.key("kind", quoted(name_of(ANCHORINGS, anchoring.kind)));
            out.key("weight", number(anchoring.weight));
        }
        if let Some(field) = &self.field {
            out.table("field");
            out.key("weight", number(field.weight));
            out.key("strength", number(field.strength));
            out.key("angle", number(field.angle));
            out.key("from", number(field.from));
            if let Some(until) = field.until {
                out.key("until", number(until));
            }
        }
        if let Some(pull) = &self.pull {
            out.table("pull");
            out.key("potential", scalar_field(&pull.potential));
        }
        if let Some(noise) = &self.noise {
            out.table("noise");
            out.key("strength", number(noise.strength));
            out.key("seed", noise.seed);
        }

        out.table("solver");
        out.key(
            "quadrature",
            quoted(name_of(QUADRATURES, self.solver.quadrature)),
        );
        out.key(
            "iteration",
            quoted(name_of(ITERATIONS, self.solver.iteration)),
        );
        out.key(
            "linear",
            quoted(name_of(LINEAR_METHODS, self.solver.linear)),
        );
        out.key("tolerance", number(self.solver.tolerance));
        out.key("law_tolerance", number(self.solver.law_tolerance));
        out.0
    }
}

/// A number, a formula or a file, as [`ScalarField`] is read.
fn scalar_field(field: &ScalarField) -> String {
    match field {
        ScalarField::Constant(value) => number(*value),
        ScalarField::Expression(expression) => quoted(expression.text()),
        ScalarField::File(nodal) => format!("{{ file = {} }}", path(nodal)),
    }
}

impl Mesh {
    fn write(&self, out: &mut Writer) {
        out.table("mesh");
        match self {
            Self::Structured {
                cells,
                jitter,
                seed,
            } => {
                out.key("kind", quoted("structured"));
                out.key("cells", cells);
                out.key("jitter", number(*jitter));
                out.key("seed", seed);
            }
            Self::Delaunay { size, seed, refine } => {
                out.key("kind", quoted("delaunay"));
                out.key("size", number(*size));
                if let Some(Refinement { band, size }) = refine {
                    let keys = [("band", number(*band)), ("size", number(*size))];
                    out.key("refine", inline(&keys));
                }
                out.key("seed", seed);
            }
            Self::File(file) => {
                out.key("kind", quoted("file"));
                out.key("path", quoted(&file.path));
            }
        }
    }
}

impl Vesicle {
    fn write(&self, out: &mut Writer) {
        out.table("vesicle");
        match &self.shape {
            Shape::Outlines(outlines) => match &outlines[..] {
                [outline] => {
                    for (key, value) in outline_keys(outline) {
                        out.key(key, value);
                    }
                }
                outlines => {
                    let parts = outlines
                        .iter()
                        .map(|outline| inline(&outline_keys(outline)));
                    let parts: String = parts.map(|part| format!("    {part},\n")).collect();
                    out.key("parts", format!("[\n{parts}]"));
                }
            },
            Shape::Random { amplitude, seed } => {
                out.key("shape", quoted("random"));
                out.key("amplitude", number(*amplitude));
                out.key("seed", seed);
            }
            Shape::File(nodal) => {
                out.key("shape", quoted("file"));
                out.key("values", path(nodal));
            }
        }
        out.key("projection", quoted(name_of(PROJECTIONS, self.projection)));
        out.key("scale", number(self.scale));
    }
}

fn outline_keys(outline: &Outline) -> Vec<(&'static str, String)> {
    let (shape, size) = match outline.curve {
        Curve::Circle { radius } => ("circle", vec![("radius", number(radius))]),
        Curve::Ellipse { half_axes } => ("ellipse", vec![("half_axes", vector(half_axes))]),
        Curve::Cassini { ratio, half_length } => (
            "cassini",
            vec![
                ("ratio", number(ratio)),
                ("half_length", number(half_length)),
            ],
        ),
        Curve::Discocyte { radius } => ("discocyte", vec![("radius", number(radius))]),
    };
    let mut keys = vec![("shape", quoted(shape))];
    keys.extend(size);
    keys.push(("center", vector(outline.center)));
    keys.push(("angle", number(outline.angle)));
    keys
}

fn initial_director(initial: &InitialDirector) -> String {
    match initial {
        InitialDirector::Uniform(director) => vector(*director),
        InitialDirector::Defects { at, angle } => {
            let defects: Vec<String> = at
                .iter()
                .map(|defect| {
                    let winding = number(defect.winding);
                    inline(&[("center", vector(defect.center)), ("winding", winding)])
                })
                .collect();
            let at = format!("[{}]", defects.join(", "));
            inline(&[
                ("kind", quoted("defects")),
                ("at", at),
                ("angle", number(*angle)),
            ])
        }
        InitialDirector::Random { seed, length } => inline(&[
            ("kind", quoted("random")),
            ("seed", seed.to_string()),
            ("length", number(*length)),
        ]),
        InitialDirector::File(nodal) => {
            inline(&[("kind", quoted("file")), ("values", path(nodal))])
        }
    }
}

/// TOML, a key a line.
struct Writer(String);

impl Writer {
    fn table(&mut self, name: &str) {
        self.0 += &format!("\n[{name}]\n");
    }

    fn key(&mut self, key: &str, value: impl Display) {
        self.0 += &format!("{key} = {value}\n");
    }
}

fn inline(keys: &[(&str, String)]) -> String {
    let keys: Vec<String> = keys
        .iter()
        .map(|(key, value)| format!("{key} = {value}"))
        .collect();
    format!("{{ {} }}", keys.join(", "))
}

fn vector([x, y]: [f64; 2]) -> String {
    format!("[{}, {}]", number(x), number(y))
}

fn path(nodal: &NodalValues) -> String {
    quoted(&nodal.path)
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// The fewest digits that read back as the same number; small ones as people write them, 1e-3.
fn number(value: f64) -> String {
    let (plain, scientific) = (format!("{value:?}"), format!("{value:e}"));
    if value.abs() < 0.1 && value != 0.0 && scientific.len() < plain.len() {
        scientific
    } else {
        plain
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_look_as_people_write_them() {
        let written = |values: &[f64]| values.iter().map(|v| number(*v)).collect::<Vec<_>>();
        assert_eq!(
            written(&[
                1e-7, 1e-3, 0.01, 0.075, 10.1, 0.0, 90.0, -0.5, 1e-5, 2.5e-7, 120.0
            ]),
            [
                "1e-7", "1e-3", "0.01", "0.075", "10.1", "0.0", "90.0", "-0.5", "1e-5", "2.5e-7",
                "120.0"
            ],
        );
    }

    proptest! {
        #[test]
        fn numbers_read_back_exactly(value in proptest::num::f64::NORMAL) {
            let text = format!("v = {}", number(value));
            let table: toml::Table = text.parse().expect("TOML");
            prop_assert_eq!(table["v"].as_float(), Some(value));
        }

        #[test]
        fn strings_read_back_exactly(value in any::<String>()) {
            let text = format!("v = {}", quoted(&value));
            let table: toml::Table = text.parse().expect("TOML");
            prop_assert_eq!(table["v"].as_str(), Some(&value[..]));
        }
    }
}
