//! `[nematic]`.

use super::{Geometry, Rules, Scene, Table};
use crate::scene::document;
use crate::scene::error::SceneError;
use crate::scene::nodal_file::{Context, NodalKey, NodalValues, read_nodal_values};
use crate::scene::parameter::{Choice, Value, choice};
use crate::scene::reader::{FINITE, Field, NOT_NEGATIVE, POSITIVE};
use crate::scene::warning::Warning;
use crate::scene::write::{inline, number, quoted, vector};

use super::vesicle::CENTER;

const DIRECTOR: NodalKey = NodalKey::vector("nematic.initial.values", "director.txt");

table! {
    /// The nematic order, E_nem = λ_nem ∫ I(φ) (½ ∇d:∇d + P(d)). Without it there is no director at all.
    pub struct Nematic {
        /// λ_nem, the weight of the energy.
        @tunable weight: f64 = 10.1, NOT_NEGATIVE;
        /// γ_nem, the mobility of the director.
        @tunable mobility: f64 = 0.5, POSITIVE;
        /// η_d: the smaller, the closer to 1 the length of d is held.
        @tunable penalty: f64 = 0.075, POSITIVE;
        /// d⁰, the director at the start.
        initial: InitialDirector = InitialDirector::Uniform([0.0, 1.0]), DIRECTOR;
    }
}

impl Rules for Nematic {
    /// Of each point around which the director turns by no whole number of turns, and by rotation of a director that is not
    /// along the axis.
    fn warnings(&self, scene: &Scene) -> Vec<Warning> {
        if let (Geometry::Axisymmetric, InitialDirector::Uniform([radial, _])) =
            (scene.geometry, &self.initial)
            && *radial != 0.0
        {
            let penalty = self.penalty;
            return vec![Warning::DefectOnAxis { penalty }];
        }
        let InitialDirector::Defects { at, .. } = &self.initial else {
            return Vec::new();
        };
        let mut points: Vec<Defect> = Vec::new();
        for defect in at {
            match points
                .iter_mut()
                .find(|point| point.center == defect.center)
            {
                Some(point) => point.winding += defect.winding,
                None => points.push(*defect),
            }
        }
        points.retain(|point| (point.winding - point.winding.round()).abs() > 1e-9);
        let warning = |Defect { center, winding }| Warning::FractionalWinding { center, winding };
        points.into_iter().map(warning).collect()
    }
}

/// The initial director d⁰.
#[derive(Debug, Clone, PartialEq)]
pub enum InitialDirector {
    /// The same vector everywhere; its length is kept.
    Uniform([f64; 2]),
    /// Unit vectors at the angle Σ winding·atan2(y − y_c, x − x_c) + angle.
    Defects {
        /// The defects.
        at: Vec<Defect>,
        /// In degrees.
        angle: f64,
    },
    /// Vectors of a given length at independent random angles.
    Random {
        /// Of the generator.
        seed: u64,
        /// |d⁰|.
        length: f64,
    },
    /// Nodal values from a file, x and y a line.
    File(NodalValues),
}

table! {
    /// A point defect of the director.
    #[derive(Copy)]
    pub struct Defect {
        /// Where it is.
        center: [f64; 2] = CENTER, FINITE;
        /// How often the director turns around it.
        winding: f64 = 1.0, FINITE;
    }
}

impl Rules for Defect {}

choice! {
    /// The word after `kind =`.
    enum Kind {
        /// Unit vectors around points.
        Defects = "defects",
        /// Independent vectors.
        Random = "random",
        /// From a file.
        File = "file",
    }
}

/// `[x, y]`, or a table whose `kind` says the rest.
impl Value for InitialDirector {
    type Bound = NodalKey;

    fn read(
        field: &Field<'_>,
        key: &NodalKey,
        context: &mut Context<'_>,
    ) -> Result<Self, SceneError> {
        match field.value() {
            document::Value::List(_) => return field.vector(FINITE).map(Self::Uniform),
            document::Value::Table(_) => {}
            _ => return Err(field.wrong_type(Self::words(key))),
        }
        let table = field.table()?;
        match table.require("kind", &field.path)?.choice(Kind::NAMES)? {
            Kind::Defects => {
                table.allow(&["kind", "at", "angle"])?;
                let at = table.require("at", "kind = \"defects\"")?;
                let at = at.items("an array such as [{ center = [0.5, 0.5], winding = 1.0 }]")?;
                let mut defect = |field: &Field<'_>| Defect::read(field.table()?, context);
                Ok(Self::Defects {
                    at: at.iter().map(&mut defect).collect::<Result<_, _>>()?,
                    angle: table.number("angle", 0.0, FINITE)?,
                })
            }
            Kind::Random => {
                table.allow(&["kind", "seed", "length"])?;
                Ok(Self::Random {
                    seed: table.seed()?,
                    length: table.number("length", 1.0, NOT_NEGATIVE)?,
                })
            }
            Kind::File => {
                table.allow(&["kind", "values"])?;
                let values = table.require("values", "kind = \"file\"")?;
                read_nodal_values(&values, *key, context).map(Self::File)
            }
        }
    }

    fn write(&self) -> Option<String> {
        Some(match self {
            Self::Uniform(director) => vector(*director),
            Self::Defects { at, angle } => {
                let at: Vec<String> = at.iter().map(|defect| inline(&defect.write())).collect();
                inline(&[
                    ("kind", quoted("defects")),
                    ("at", format!("[{}]", at.join(", "))),
                    ("angle", number(*angle)),
                ])
            }
            Self::Random { seed, length } => inline(&[
                ("kind", quoted("random")),
                ("seed", seed.to_string()),
                ("length", number(*length)),
            ]),
            Self::File(nodal) => {
                inline(&[("kind", quoted("file")), ("values", quoted(&nodal.path))])
            }
        })
    }

    fn words(_: &NodalKey) -> String {
        "a vector such as [0.0, 1.0], or a table with kind = \"defects\", \"random\" or \"file\""
            .to_owned()
    }

    fn nodal_key(key: &NodalKey) -> Option<NodalKey> {
        Some(*key)
    }

    fn nodal_values(&mut self) -> Option<&mut NodalValues> {
        match self {
            Self::File(file) => Some(file),
            Self::Uniform(_) | Self::Defects { .. } | Self::Random { .. } => None,
        }
    }
}
