//! The tables of a scene, a file each. `table!` declares a table: each parameter once, with its key, type,
//! default, bound and what it is. From it follow the type, reading, writing, the allowed keys and near misses,
//! `--set`, and the guide's tables. What else there is to know of a table it says by [`Rules`].
//!
//! The tables of the effects are optional: without its table, a scene is without the effect. They are listed
//! below; from the list follows all that must know of them.

use super::change::{Change, read_changes};
use super::error::{Problem, SceneError};
use super::nodal_file::{Context, NodalKey, NodalValues};
use super::parameter::{DefaultValue, Parameter, ParameterValue, Value};
use super::reader::{Field as TomlField, Reader};
use super::warning::Warning;
use super::write::quoted;

/// A table of a scene.
pub(super) trait Table: Rules {
    /// What it is about.
    fn words() -> &'static str
    where
        Self: Sized;

    /// Its parameters, in the order in which they are written.
    fn parameters() -> Vec<Parameter>
    where
        Self: Sized;

    /// Reads and checks it.
    fn read(table: Reader<'_>, context: &mut Context<'_>) -> Result<Self, SceneError>
    where
        Self: Sized;

    /// Its keys and their values as TOML.
    fn write(&self) -> Vec<(&'static str, String)>;

    /// Reads a value for a parameter of it that can change while a run goes; `None`: for no such parameter, or a value that it
    /// cannot change to.
    fn read_tunable(
        _key: &str,
        _value: &TomlField<'_>,
        _context: &mut Context<'_>,
    ) -> Result<Option<ParameterValue>, SceneError>
    where
        Self: Sized,
    {
        Ok(None)
    }

    /// The value of one of its parameters, if it is one that changes have.
    fn parameter(&self, _key: &str) -> Option<ParameterValue> {
        None
    }

    /// Gives one of its parameters the value of a change; returns whether it has taken it.
    fn set_parameter(&mut self, _key: &str, _value: &ParameterValue) -> bool {
        false
    }

    /// Whether it [needs the director](Rules::needs_director).
    fn is_on_director(&self) -> bool {
        false
    }

    /// Its files of nodal values.
    fn nodal_files(&mut self) -> Vec<(NodalKey, &mut NodalValues)> {
        Vec::new()
    }
}

/// What holds for a table beyond its parameters one by one.
pub(super) trait Rules {
    /// Before its values are read: leaves out keys that others take the place of.
    fn prepare(_table: &mut Reader<'_>) -> Result<(), SceneError>
    where
        Self: Sized,
    {
        Ok(())
    }

    /// When its values are read: what they make of each other.
    fn complete(&mut self, _table: &Reader<'_>) -> Result<(), SceneError> {
        Ok(())
    }

    /// What it demands of the other tables.
    fn check_scene(&self, _scene: &Scene, _table: &Reader<'_>) -> Result<(), SceneError> {
        Ok(())
    }

    /// Whether this key is left out when the table is written.
    fn leaves_out(&self, _key: &str) -> bool {
        false
    }

    /// Whether it is of an effect on the director, so that it goes when `[nematic]` goes.
    fn needs_director() -> bool
    where
        Self: Sized,
    {
        false
    }

    /// It needs the director, and the scene has none.
    fn without_director(&self, name: &'static str, table: &Reader<'_>) -> Result<(), SceneError> {
        Err(table.error(Problem::DirectorWithoutNematic { table: name }))
    }

    /// The changes that keys of its own stand for, as `from` and `until` of a field do.
    fn changes(&self) -> Vec<Change> {
        Vec::new()
    }

    /// Makes it what it is before these.
    fn undo_changes(&mut self) {}

    /// What is allowed in it but probably not meant.
    fn warnings(&self, _scene: &Scene) -> Vec<Warning> {
        Vec::new()
    }
}

/// Declares a table: `key: type = default, bound;`. A parameter without a default must be given. Of the bound,
/// see the type in `parameter.rs`; a choice has none. `@tunable` before the key: it can change while a run goes.
macro_rules! table {
    (@default $Table:ident $($key:ident: $Type:ty = $default:expr,)+) => {
        impl Default for $Table {
            fn default() -> Self {
                Self { $($key: $default),+ }
            }
        }
    };
    (@default $($rest:tt)*) => {};
    (@missing $table:ident, $key:ident, $default:expr) => { $default };
    (@missing $table:ident, $key:ident) => {
        return Err($table.missing(stringify!($key), format!("[{}]", $table.path)))
    };
    (@words $Type:ty, $default:expr) => { DefaultValue::of::<$Type>(&$default) };
    (@words $Type:ty) => { DefaultValue::Required };
    (@bound $bound:expr) => { &$bound };
    (@bound) => { &() };
    (@is_tunable tunable) => { true };
    (@is_tunable) => { false };
    (
        $(#[doc = $about:literal])+
        $(#[derive($($derive:path),+)])?
        pub struct $Table:ident {
            $(
                $(#[doc = $words:literal])+
                $(@ $tunable:ident)? $key:ident: $Type:ty $(= $default:expr)? $(, $bound:expr)?;
            )+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, PartialEq $($(, $derive)+)?)]
        pub struct $Table {
            $($(#[doc = $words])+ pub $key: $Type,)+
        }

        table! { @default $Table $($key: $Type $(= $default)?,)+ }

        const _: () = {
            use $crate::scene::tables::*;

            impl Table for $Table {
                fn words() -> &'static str {
                    concat!($($about),+).trim()
                }

                fn parameters() -> Vec<Parameter> {
                    vec![$(Parameter {
                        key: stringify!($key),
                        words: concat!($($words),+).trim(),
                        default: table!(@words $Type $(, $default)?),
                        allowed: <$Type as Value>::words(table!(@bound $($bound)?)),
                        nodal_key: <$Type as Value>::nodal_key(table!(@bound $($bound)?)),
                        kinds: &[],
                        is_tunable: table!(@is_tunable $($tunable)?),
                    }),+]
                }

                fn read_tunable(
                    key: &str,
                    value: &TomlField<'_>,
                    context: &mut Context<'_>,
                ) -> Result<Option<ParameterValue>, SceneError> {
                    $(if key == stringify!($key) && table!(@is_tunable $($tunable)?) {
                        let value: $Type = Value::read(value, table!(@bound $($bound)?), context)?;
                        return Ok(value.to_parameter());
                    })+
                    Ok(None)
                }

                fn parameter(&self, key: &str) -> Option<ParameterValue> {
                    $(if key == stringify!($key) {
                        return self.$key.to_parameter();
                    })+
                    None
                }

                fn set_parameter(&mut self, key: &str, value: &ParameterValue) -> bool {
                    $(if key == stringify!($key) {
                        return self.$key.set_parameter(value);
                    })+
                    false
                }

                fn read(
                    mut table: Reader<'_>,
                    context: &mut Context<'_>,
                ) -> Result<Self, SceneError> {
                    table.allow(&[$(stringify!($key)),+])?;
                    Self::prepare(&mut table)?;
                    let mut read = Self {
                        $($key: match table.get(stringify!($key)) {
                            Some(field) => Value::read(&field, table!(@bound $($bound)?), context)?,
                            None => table!(@missing table, $key $(, $default)?),
                        }),+
                    };
                    read.complete(&table)?;
                    Ok(read)
                }

                fn write(&self) -> Vec<(&'static str, String)> {
                    let values = [$((stringify!($key), Value::write(&self.$key))),+];
                    let values = values.into_iter().filter(|(key, _)| !self.leaves_out(key));
                    values.filter_map(|(key, value)| Some((key, value?))).collect()
                }

                fn is_on_director(&self) -> bool {
                    Self::needs_director()
                }

                fn nodal_files(&mut self) -> Vec<(NodalKey, &mut NodalValues)> {
                    let files = [$((
                        <$Type as Value>::nodal_key(table!(@bound $($bound)?)),
                        self.$key.nodal_values(),
                    )),+];
                    let files = files.into_iter();
                    files.filter_map(|(key, values)| key.zip(values)).collect()
                }
            }
        };
    };
}

// After the macro, which they use. The effects' are declared below.
mod domain;
mod membrane;
mod mesh;
mod rest;
mod solver;
mod time;
mod vesicle;

use domain::Domain;

pub use anchoring::AnchoringKind;
pub use domain::{Boundary, Geometry};
pub use membrane::Membrane;
pub(super) use mesh::{LONGEST_EDGE, SHORTEST_EDGE};
pub use mesh::{Mesh, Refinement};
pub use nematic::{Defect, InitialDirector};
pub use rest::Rest;
pub use solver::{Iteration, LinearMethod, Quadrature, Solver};
pub(super) use time::MOST_STEPS;
pub use time::{Time, TimeScheme};
pub use vesicle::{Curve, Outline, Projection, Shape, Vesicle};

/// The name of the table that ends a run at rest.
const REST: &str = "rest";

/// Declares [`Scene`] with the tables of its effects.
macro_rules! scene {
    ($($(#[cfg($cfg:meta)])? $name:ident: $Table:ident,)+) => {
        $(
            $(#[cfg($cfg)])?
            mod $name;
            $(#[cfg($cfg)])?
            pub use $name::$Table;
        )+

        /// One simulation, complete: every default filled in, every value checked.
        #[derive(Debug, Clone, PartialEq)]
        pub struct Scene {
            /// A title for people.
            pub name: String,
            /// What Ω stands for.
            pub geometry: Geometry,
            /// What holds on ∂Ω.
            pub boundary: Boundary,
            /// The triangulation.
            pub mesh: Mesh,
            /// φ⁰.
            pub vesicle: Vesicle,
            /// Δt and T.
            pub time: Time,
            /// `[rest]`; `None`: the run goes to T.
            pub rest: Option<Rest>,
            /// The membrane and its bending: ε, γ_ben, k(x).
            pub membrane: Membrane,
            $(
                $(#[cfg($cfg)])?
                #[doc = concat!("`[", stringify!($name), "]`; `None`: the scene is without this effect.")]
                pub $name: Option<$Table>,
            )+
            /// How the equations are solved.
            pub solver: Solver,
            /// What changes while the run goes, in the order of time; of the same time, in the order of the text.
            pub changes: Vec<Change>,
        }

        /// A scene that says nothing: bending alone.
        impl Default for Scene {
            fn default() -> Self {
                Self {
                    name: "Untitled".to_owned(),
                    geometry: Domain::default().geometry,
                    boundary: Domain::default().boundary,
                    mesh: Mesh::default(),
                    vesicle: Vesicle::default(),
                    time: Time::default(),
                    rest: None,
                    membrane: Membrane::default(),
                    $($(#[cfg($cfg)])? $name: None,)+
                    solver: Solver::default(),
                    changes: Vec::new(),
                }
            }
        }

        /// The names of the effects that have a table.
        pub(super) const EFFECTS: &[&str] = &[$($(#[cfg($cfg)])? stringify!($name)),+];

        /// The tables that a scene may be without.
        pub(super) fn is_optional(table: &str) -> bool {
            table == REST || EFFECTS.contains(&table)
        }

        /// A value for each effect that has a table: one that is forgotten does not compile.
        #[derive(Debug)]
        #[allow(dead_code, reason = "a check at compile time; the values are never read")]
        pub struct EachEffect<T> {
            $(
                $(#[cfg($cfg)])?
                #[doc = concat!("Of `[", stringify!($name), "]`.")]
                pub $name: T,
            )+
        }

        /// What the tables of a scene are, in the order in which they are written.
        pub fn tables() -> Vec<TableInfo> {
            Vec::from([
                TableInfo::new::<Domain>("domain"),
                TableInfo::new::<Mesh>("mesh"),
                TableInfo::new::<Vesicle>("vesicle"),
                TableInfo::new::<Time>("time"),
                TableInfo::new::<Rest>(REST),
                TableInfo::new::<Membrane>("membrane"),
                $($(#[cfg($cfg)])? TableInfo::new::<$Table>(stringify!($name)),)+
                TableInfo::new::<Solver>("solver"),
            ])
        }

        impl Scene {
            /// The tables of a document.
            pub(super) fn read(
                name: String,
                top: &Reader<'_>,
                mut context: Context<'_>,
            ) -> Result<Self, SceneError> {
                context.mesh = Mesh::read(top.table("mesh")?, &mut context)?;
                let context = &mut context;
                let domain = Domain::read(top.table("domain")?, context)?;
                let mut scene = Self {
                    name,
                    geometry: domain.geometry,
                    boundary: domain.boundary,
                    vesicle: Vesicle::read(top.table("vesicle")?, context)?,
                    time: Time::read(top.table("time")?, context)?,
                    rest: match top.present(REST)? {
                        Some(table) => Some(Rest::read(table, context)?),
                        None => None,
                    },
                    membrane: Membrane::read(top.table("membrane")?, context)?,
                    $($(#[cfg($cfg)])? $name: match top.present(stringify!($name))? {
                        Some(table) => Some($Table::read(table, context)?),
                        None => None,
                    },)+
                    solver: Solver::read(top.table("solver")?, context)?,
                    mesh: context.mesh.clone(),
                    changes: Vec::new(),
                };
                for (name, table) in scene.named_tables() {
                    let read = top.table(name)?;
                    if table.is_on_director() && scene.nematic.is_none() {
                        table.without_director(name, &read)?;
                    }
                    table.check_scene(&scene, &read)?;
                }
                read_changes(top, &mut scene, context)?;
                Ok(scene)
            }

            /// What of the scene a change can concern: all but the mesh, the shape, and the changes.
            pub(super) fn without_geometry(&self) -> Self {
                Self {
                    geometry: self.geometry,
                    boundary: self.boundary,
                    time: self.time,
                    membrane: self.membrane.clone(),
                    $($(#[cfg($cfg)])? $name: self.$name.clone(),)+
                    solver: self.solver,
                    ..Self::default()
                }
            }

            /// Reads a value for a parameter that can change while a run goes; `None`: for no such parameter, or a value that
            /// it cannot change to.
            pub(super) fn read_tunable(
                [table, key]: [&str; 2],
                value: &TomlField<'_>,
                context: &mut Context<'_>,
            ) -> Result<Option<ParameterValue>, SceneError> {
                if table == "membrane" {
                    return Membrane::read_tunable(key, value, context);
                }
                $(
                    $(#[cfg($cfg)])?
                    {
                        if table == stringify!($name) {
                            return $Table::read_tunable(key, value, context);
                        }
                    }
                )+
                Ok(None)
            }

            /// Gives a parameter the value of a change, and brings the effect in if it is not there; returns whether the
            /// parameter has taken it.
            pub(super) fn set_parameter(
                &mut self,
                [table, key]: [&str; 2],
                value: &ParameterValue,
            ) -> bool {
                if table == "membrane" {
                    return self.membrane.set_parameter(key, value);
                }
                $(
                    $(#[cfg($cfg)])?
                    {
                        if table == stringify!($name) {
                            let table = self.$name.get_or_insert_default();
                            return table.set_parameter(key, value);
                        }
                    }
                )+
                false
            }

            /// The tables that it has, but for `[domain]`.
            fn named_tables(&self) -> impl Iterator<Item = (&'static str, &dyn Table)> {
                let tables: [(&'static str, Option<&dyn Table>); _] = [
                    ("mesh", Some(&self.mesh)),
                    ("vesicle", Some(&self.vesicle)),
                    ("time", Some(&self.time)),
                    (REST, self.rest.as_ref().map(|table| table as &dyn Table)),
                    ("membrane", Some(&self.membrane)),
                    $(
                        $(#[cfg($cfg)])?
                        (stringify!($name), self.$name.as_ref().map(|table| table as &dyn Table)),
                    )+
                    ("solver", Some(&self.solver)),
                ];
                let tables = tables.into_iter();
                tables.filter_map(|(name, table)| Some((name, table?)))
            }

            /// The tables that may have files.
            pub(super) fn tables_mut(&mut self) -> impl Iterator<Item = &mut dyn Table> {
                let tables = [
                    Some(&mut self.vesicle as &mut dyn Table),
                    Some(&mut self.membrane),
                    $(
                        $(#[cfg($cfg)])?
                        self.$name.as_mut().map(|table| table as &mut dyn Table),
                    )+
                ];
                tables.into_iter().flatten()
            }

            /// Takes away the table of an effect, and with `[nematic]` those that need the director. Whether it
            /// was there.
            pub fn remove_effect(&mut self, name: &str) -> bool {
                let takes_director = name == "nematic" && self.nematic.is_some();
                let mut was_there = false;
                $(
                    $(#[cfg($cfg)])?
                    {
                        let is_it = name == stringify!($name);
                        if is_it || takes_director && $Table::needs_director() {
                            was_there |= self.$name.take().is_some() && is_it;
                        }
                    }
                )+
                was_there
            }
        }
    };
}

// One line an effect; the last one is the guide's example.
scene! {
    area: Area,
    nematic: Nematic,
    anchoring: Anchoring,
    field: Field,
    pull: Pull,
    noise: Noise,
    #[cfg(test)]
    tension: Tension,
}

impl Scene {
    /// The scene as TOML, complete: every key, defaults too. [`Scene::parse`] reads it back as an equal scene.
    pub fn to_toml(&self) -> String {
        let domain = Domain {
            geometry: self.geometry,
            boundary: self.boundary,
        };
        let tables = [("domain", &domain as &dyn Table)].into_iter();
        let mut text = format!("name = {}\n", quoted(&self.name));
        for (name, table) in tables.chain(self.named_tables()) {
            text += &format!("\n[{name}]\n");
            for (key, value) in table.write() {
                text += &format!("{key} = {value}\n");
            }
        }
        for change in &self.changes {
            text += &format!("\n[[change]]\n{}", change.to_toml());
        }
        text
    }

    /// The value of a parameter, such as `area.target`, if it is one that changes have.
    pub fn parameter(&self, key: &str) -> Option<ParameterValue> {
        let (name, key) = key.split_once('.')?;
        let (_, table) = self.named_tables().find(|(table, _)| *table == name)?;
        table.parameter(key)
    }

    /// All changes: those that keys of its tables stand for, and its `[[change]]`, in the order of time.
    pub(super) fn all_changes(&self) -> Vec<Change> {
        let of_tables = self.named_tables().flat_map(|(_, table)| table.changes());
        let mut changes: Vec<Change> = of_tables.chain(self.changes.iter().cloned()).collect();
        changes.sort_by(|a, b| a.at.total_cmp(&b.at));
        changes
    }

    /// Makes the tables what they are before the changes that keys of theirs stand for.
    pub(super) fn undo_table_changes(&mut self) {
        self.tables_mut().for_each(|table| table.undo_changes());
    }

    /// The tables of effects that it has.
    pub fn effects(&self) -> impl Iterator<Item = &'static str> {
        let names = self.named_tables().map(|(name, _)| name);
        names.filter(|name| EFFECTS.contains(name))
    }

    /// What the tables that it has warn of.
    pub(super) fn table_warnings(&self) -> impl Iterator<Item = Warning> {
        self.named_tables()
            .flat_map(|(_, table)| table.warnings(self))
    }
}

/// What a table is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableInfo {
    /// Its name.
    pub name: &'static str,
    /// What it is about.
    pub words: &'static str,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// Whether it needs `[nematic]`.
    pub needs_director: bool,
}

impl TableInfo {
    fn new<T: Table>(name: &'static str) -> Self {
        Self {
            name,
            words: T::words(),
            parameters: T::parameters(),
            needs_director: T::needs_director(),
        }
    }

    /// Whether it is of an effect, so that a scene may be without it.
    pub fn is_effect(&self) -> bool {
        EFFECTS.contains(&self.name)
    }
}

/// The first table that has a key of this name.
pub(super) fn table_with(key: &str) -> Option<&'static str> {
    let has_key = |table: &TableInfo| table.parameters.iter().any(|it| it.key == key);
    Some(tables().into_iter().find(has_key)?.name)
}
