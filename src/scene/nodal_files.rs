//! Every file of nodal values that a scene has, in one place: what reads a scene, copies its inputs or
//! asks whether it can have another mesh takes them from here.

use super::model::{
    InitialDirector, Membrane, Nematic, NodalValues, Pull, ScalarField, Scene, Shape, Vesicle,
};

/// Which values of a scene a file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NodalKey {
    /// φ⁰.
    Vesicle,
    /// k(x).
    SpontaneousCurvature,
    /// d⁰.
    Director,
    /// U(x).
    Pull,
}

impl NodalKey {
    /// All there are.
    pub const ALL: [Self; 4] = [
        Self::Vesicle,
        Self::SpontaneousCurvature,
        Self::Director,
        Self::Pull,
    ];

    /// The key in the scene that names the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vesicle => "vesicle.values",
            Self::SpontaneousCurvature => "membrane.spontaneous_curvature",
            Self::Director => "nematic.initial.values",
            Self::Pull => "pull.potential",
        }
    }

    /// The name that a copy of the file has.
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Vesicle => "vesicle.txt",
            Self::SpontaneousCurvature => "spontaneous_curvature.txt",
            Self::Director => "director.txt",
            Self::Pull => "pull.txt",
        }
    }

    /// Values a node.
    pub fn columns(self) -> usize {
        match self {
            Self::Vesicle | Self::SpontaneousCurvature | Self::Pull => 1,
            Self::Director => 2,
        }
    }
}

impl Scene {
    /// Every file of nodal values that the scene has.
    pub fn nodal_files(&self) -> Vec<(NodalKey, NodalValues)> {
        let mut scene = self.clone();
        let files = scene.nodal_files_mut().into_iter();
        files.map(|(key, file)| (key, file.clone())).collect()
    }

    /// Every file of nodal values that the scene has, to be changed.
    pub fn nodal_files_mut(&mut self) -> Vec<(NodalKey, &mut NodalValues)> {
        // Every table is named, so that a new one is not forgotten.
        let Self {
            name: _,
            boundary,
            mesh: _,
            vesicle,
            time,
            membrane,
            area,
            nematic,
            anchoring,
            field,
            pull,
            noise,
            solver,
        } = self;
        has_no_file(boundary);
        has_no_file(time);
        has_no_file(area);
        has_no_file(anchoring);
        has_no_file(field);
        has_no_file(noise);
        has_no_file(solver);
        let Vesicle {
            shape,
            projection: _,
            scale: _,
        } = vesicle;
        let Membrane {
            interface_width: _,
            mobility: _,
            spontaneous_curvature,
        } = membrane;
        let vesicle = match shape {
            Shape::File(file) => Some(file),
            Shape::Outlines(_) | Shape::Random { .. } => None,
        };
        let director = nematic.as_mut().and_then(|nematic| {
            let Nematic {
                weight: _,
                mobility: _,
                penalty: _,
                initial,
            } = nematic;
            match initial {
                InitialDirector::File(file) => Some(file),
                InitialDirector::Uniform(_)
                | InitialDirector::Defects { .. }
                | InitialDirector::Random { .. } => None,
            }
        });
        let pull = pull
            .as_mut()
            .and_then(|Pull { potential }| of_field(potential));
        let files = [
            (NodalKey::Vesicle, vesicle),
            (
                NodalKey::SpontaneousCurvature,
                of_field(spontaneous_curvature),
            ),
            (NodalKey::Director, director),
            (NodalKey::Pull, pull),
        ];
        let files = files.into_iter();
        files.filter_map(|(key, file)| Some((key, file?))).collect()
    }
}

/// What can be copied bit by bit has no values from a file.
fn has_no_file<Table: Copy>(_: &Table) {}

fn of_field(field: &mut ScalarField) -> Option<&mut NodalValues> {
    match field {
        ScalarField::File(file) => Some(file),
        ScalarField::Constant(_) | ScalarField::Expression(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scene with a file for just one of its values.
    fn scene(key: NodalKey) -> Scene {
        let settings = match key {
            NodalKey::Vesicle => "vesicle = { shape = 'file', values = 'a.txt' }",
            NodalKey::SpontaneousCurvature => "membrane.spontaneous_curvature = { file = 'a.txt' }",
            NodalKey::Director => "nematic.initial = { kind = 'file', values = 'a.txt' }",
            NodalKey::Pull => "pull.potential = { file = 'a.txt' }",
        };
        let text = format!("mesh.cells = 8\n{settings}");
        let line = "0.5 ".repeat(key.columns()) + "\n";
        let mut read = |_: &str| Ok(line.repeat(81).into_bytes());
        Scene::parse(&text, "a test", &[], &mut read).expect("a scene")
    }

    #[test]
    fn every_file_is_found_by_its_key() {
        for key in NodalKey::ALL {
            let files = scene(key).nodal_files();
            let [(found, file)] = &files[..] else {
                panic!("{key:?}: {files:?}");
            };
            assert_eq!(
                (*found, file.columns, &*file.path),
                (key, key.columns(), "a.txt")
            );
            assert!(scene(key).to_toml().contains("a.txt"), "{key:?}");
        }
        let none = Scene::parse("", "empty", &[], &mut |_| unreachable!());
        assert!(none.expect("a scene").nodal_files().is_empty());
    }
}
