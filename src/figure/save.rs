//! Figures as files.

use super::canvas::Drawing;
use super::data::{Field, RunData, RunLabel, Snapshot, View, check_fields, file_name, five};
use super::provenance::{Provenance, Shown};
use super::scalars::{self, ScalarFigure};
use super::strip::{self, Strip};
use super::table::{write_state, write_strips};
use super::text::Label;
use super::{Existing, FigureError, FigureOptions, curves, needs, pixels, png, svg, view};
use crate::fem::Contour;
use crate::geometry::Point;
use crate::record::{
    Number, make_folder, write_fields, write_new, write_series, write_surface, write_whole,
};
use crate::scene::{Geometry, Scene};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Saves a view in a folder: `<name>-step-<step>`, with the field if it is not φ, as PNG, SVG and CSV (the values at the
/// nodes). Gives the files. The folder is made if it is not there.
///
/// # Errors
/// [`FigureError`]; the files that were written before it stay.
pub fn save_view(
    view: &View,
    options: &FigureOptions,
    folder: &Path,
) -> Result<Vec<PathBuf>, FigureError> {
    options.check()?;
    check_fields(view.name, view.mesh, view.state, view.report.t)?;
    let label = RunLabel::new(view.name, view.scene, view.report.t);
    let (step, t) = (view.report.step, view.report.t);
    let (what, suffix) = what_and_suffix(view.field);
    let stem = format!("{}-step-{step:07}{suffix}", label.file);
    let mut files = Files::claim(folder, vec![stem], &PICTURE, options)?;
    let shown = Shown {
        label: &label,
        scene: view.scene,
        times: vec![(step, t)],
    };
    let provenance = Provenance::new(what, view.command, &[shown]);
    let stem = files.stem(0);
    // The numbers first: a picture may be what there is no memory for.
    files.write(&stem, "csv", |file| {
        write_state(file, &label.file, view.mesh, (step, t), view.state)
    })?;
    let drawing = view::draw(view, &label, options)?;
    files.picture(&stem, &drawing, options, &provenance)?;
    Ok(files.written)
}

/// Saves the shape at rest of a membrane over its initial state: `<name>-shape` as PNG and SVG, and the outline as CSV, a point a
/// row. Gives the files. The folder is made if it is not there.
///
/// # Errors
/// [`FigureError`]; the files that were written before it stay.
pub fn save_shape(
    view: &View,
    outline: &[Point],
    options: &FigureOptions,
    folder: &Path,
) -> Result<Vec<PathBuf>, FigureError> {
    options.check()?;
    let label = RunLabel::new(view.name, view.scene, 0.0);
    let stem = format!("{}-shape", file_name(view.name));
    let mut files = Files::claim(folder, vec![stem], &PICTURE, options)?;
    let stem = files.stem(0);
    let mut text = "x,y\n".to_owned();
    for point in outline {
        text += &format!("{},{}\n", Number(point.x), Number(point.y));
    }
    files.text(&stem, "csv", &text)?;
    let shown = Shown {
        label: &label,
        scene: view.scene,
        times: vec![(view.report.step, view.report.t)],
    };
    let provenance = Provenance::new("Shape at rest", view.command, &[shown]);
    files.picture(
        &stem,
        &view::draw(view, &label, options)?,
        options,
        &provenance,
    )?;
    Ok(files.written)
}

/// What a view shows, and the field in the name of its files; φ is not named.
fn what_and_suffix(field: Field) -> (&'static str, &'static str) {
    match field {
        Field::Phase => ("View of φ", ""),
        Field::DirectorLength => ("View of |d|", "-director"),
        Field::Bending => ("View of ω", "-omega"),
        Field::Potential => ("View of μ", "-mu"),
        Field::BendingDensity { .. } => ("View of ε/2 ω²", "-bending-density"),
    }
}

/// Saves all figures of some runs in a folder, and gives the files. For each run:
///
/// | file | what it shows |
/// |---|---|
/// | `<name>-snapshots` | φ, the membrane and the director at t = 0, T/4, T/2, 3T/4, T |
/// | `<name>-energies` | E_total and each of its parts |
/// | `<name>-volume-area` | the drift of ∫φ, and B with β |
/// | `<name>-outline` | length, waist and greatest width of the vesicle |
///
/// each as PNG and SVG, with its data as CSV; with [`FigureOptions::fields`] also the snapshots as
/// VTU files in `<name>-fields/` and their list, `<name>-fields.pvd`, and the history; with
/// [`FigureOptions::revolve`] also the surface of a body of rotation in space, `<name>-surface.vtu`. Of several
/// runs, the same again for all of them together, as `all-…`.
///
/// # Errors
/// [`FigureError`]; the files that were written before it stay.
pub fn save_set(
    runs: &[RunData],
    options: &FigureOptions,
    folder: &Path,
) -> Result<Vec<PathBuf>, FigureError> {
    options.check()?;
    for run in runs {
        for snapshot in &run.snapshots {
            check_fields(&run.name, &snapshot.mesh, &snapshot.state, snapshot.t)?;
        }
    }
    let labels = RunLabel::of_all((runs.iter()).map(|run| (&*run.name, &*run.scene)));
    let mut groups: Vec<(String, std::ops::Range<usize>)> = Vec::new();
    for (number, label) in labels.iter().enumerate() {
        groups.push((label.file.clone(), number..number + 1));
    }
    if runs.len() > 1 {
        groups.push((ALL.to_owned(), 0..runs.len()));
    }
    let sets: Vec<Set> = groups
        .into_iter()
        .map(|(name, range)| {
            let (runs, labels) = (&runs[range.clone()], &labels[range]);
            Set::new(name, runs, labels)
        })
        .collect();
    let stems: Vec<String> = sets.iter().flat_map(Set::stems).collect();
    if stems.is_empty() {
        return Err(FigureError::Nothing);
    }
    let mut files = Files::claim(folder, stems, &["png", "svg", "csv", "pvd"], options)?;
    // The numbers first: a picture may be what there is no memory for.
    for set in &sets {
        set.save_tables(&mut files)?;
    }
    if options.fields {
        for (run, label) in runs.iter().zip(&labels) {
            save_fields(run, label, &mut files)?;
        }
    }
    if let Some(around) = options.revolve {
        for (run, label) in runs.iter().zip(&labels) {
            save_surface(run, label, around, &mut files)?;
        }
    }
    for set in &sets {
        set.save_pictures(&mut files, options)?;
    }
    Ok(files.written)
}

/// Whether the files of a set of these runs, each with its name, can go into a folder: before the
/// runs are computed.
///
/// # Errors
/// [`FigureError::Occupied`] with the first file that is in the way.
pub fn check_free(runs: &[(&str, &Scene)], folder: &Path) -> Result<(), FigureError> {
    let labels = RunLabel::of_all(runs.iter().map(|(name, scene)| (*name, *scene)));
    let names = labels.iter().map(|label| label.file.as_str());
    for name in names.chain((runs.len() > 1).then_some(ALL)) {
        let figures = scalars::FILES.into_iter().chain([SNAPSHOTS]);
        for (figure, extension) in figures.flat_map(|figure| PICTURE.map(|e| (figure, e))) {
            let path = folder.join(format!("{name}-{figure}.{extension}"));
            if path.symlink_metadata().is_ok() {
                return Err(FigureError::Occupied { path });
            }
        }
    }
    Ok(())
}

/// What the files of several runs together are called by.
const ALL: &str = "all";
/// What the files of the strips are called by.
const SNAPSHOTS: &str = "snapshots";
/// The files of a figure.
const PICTURE: [&str; 3] = ["png", "svg", "csv"];

/// The figures of one run, or of several together.
struct Set<'a> {
    name: String,
    runs: &'a [RunData],
    labels: &'a [RunLabel],
    strips: Vec<Vec<&'a Snapshot>>,
    scalars: Vec<ScalarFigure>,
}

impl<'a> Set<'a> {
    fn new(name: String, runs: &'a [RunData], labels: &'a [RunLabel]) -> Self {
        Set {
            name,
            runs,
            labels,
            strips: runs.iter().map(|run| five(&run.snapshots)).collect(),
            scalars: scalars::figures(runs, labels),
        }
    }

    fn has_strip(&self) -> bool {
        self.strips.iter().any(|strip| !strip.is_empty())
    }

    /// The names of its files, without what stands after the point.
    fn stems(&self) -> Vec<String> {
        let strip = self.has_strip().then_some(SNAPSHOTS);
        let scalars = self.scalars.iter().map(|figure| figure.file);
        let figures = strip.into_iter().chain(scalars);
        figures.map(|figure| self.stem(figure)).collect()
    }

    fn stem(&self, figure: &str) -> String {
        format!("{}-{figure}", self.name)
    }

    fn save_tables(&self, files: &mut Files) -> Result<(), FigureError> {
        if self.has_strip() {
            let labels = self.labels.iter().map(|label| &*label.file);
            let strips = labels.zip(&self.strips);
            let strips = strips.map(|(label, strip)| (label, &strip[..]));
            let stem = files.renamed(&self.stem(SNAPSHOTS));
            files.write(&stem, "csv", |file| write_strips(file, strips))?;
        }
        for figure in &self.scalars {
            let stem = files.renamed(&self.stem(figure.file));
            files.text(&stem, "csv", figure.table.text())?;
        }
        Ok(())
    }

    fn save_pictures(&self, files: &mut Files, options: &FigureOptions) -> Result<(), FigureError> {
        if self.has_strip() {
            self.save_strip(files, options)?;
        }
        let keys = scalars::keys(self.labels);
        for figure in &self.scalars {
            let title = match self.labels {
                [label] => format!("{}: {}", figure.what, label.title),
                _ => figure.what.to_owned(),
            };
            let plots = (&*figure.plots, figure.abscissa.as_ref());
            let drawing = curves::draw(&Label::text(&title), &keys, plots, options)?;
            let provenance = self.provenance(figure.what, |number| {
                let history = &self.runs[number].history;
                let [steps, times] =
                    ["step", "t"].map(|name| history.column(name).unwrap_or_default());
                let ends = [0, steps.len().saturating_sub(1)];
                let at = |row: usize| Some((*steps.get(row)? as u64, *times.get(row)?));
                let mut ends: Vec<_> = ends.into_iter().filter_map(at).collect();
                ends.dedup();
                ends
            });
            let stem = files.renamed(&self.stem(figure.file));
            files.picture(&stem, &drawing, options, &provenance)?;
        }
        Ok(())
    }

    fn save_strip(&self, files: &mut Files, options: &FigureOptions) -> Result<(), FigureError> {
        let mut strips = Vec::new();
        let runs = self.runs.iter().zip(self.labels).zip(&self.strips);
        for ((run, label), snapshots) in runs {
            if !snapshots.is_empty() {
                strips.push(Strip {
                    title: Label::text(&label.title),
                    snapshots: snapshots.clone(),
                    theory: run.theory.as_deref(),
                });
            }
        }
        let provenance = self.provenance("Snapshots", |number| {
            let times = self.strips[number].iter();
            times.map(|snapshot| (snapshot.step, snapshot.t)).collect()
        });
        let stem = files.renamed(&self.stem(SNAPSHOTS));
        files.picture(&stem, &strip::draw(&strips, options)?, options, &provenance)
    }

    fn provenance(&self, what: &str, times: impl Fn(usize) -> Vec<(u64, f64)>) -> Provenance {
        let shown = |(number, (run, label)): (usize, (&'a RunData, &'a RunLabel))| Shown {
            label,
            scene: &run.scene,
            times: times(number),
        };
        let runs = self.runs.iter().zip(self.labels).enumerate();
        let shown: Vec<Shown> = runs.map(shown).collect();
        let command = self.runs.first().map_or("", |run| &run.command);
        Provenance::new(what, command, &shown)
    }
}

/// The snapshots as VTU files with their list, and the history.
fn save_fields(run: &RunData, label: &RunLabel, files: &mut Files) -> Result<(), FigureError> {
    let stem = files.renamed(&label.file);
    let name = format!("{stem}-fields");
    let fields = files.folder.join(&name);
    make_folder(&fields)?;
    let mut series = Vec::new();
    for snapshot in &run.snapshots {
        let file = format!("step-{:07}.vtu", snapshot.step);
        let path = fields.join(&file);
        write_fields(&path, &snapshot.mesh, &snapshot.state, snapshot.t)?;
        files.written.push(path);
        series.push((snapshot.t, format!("{name}/{file}")));
    }
    let path = files.path(&name, "pvd");
    write_series(&path, &series)?;
    files.written.push(path);
    let path = files.path(&format!("{stem}-history"), "csv");
    let text = run.history.to_csv();
    write_whole(&path, |file| file.write_all(text.as_bytes()))?;
    files.written.push(path);
    Ok(())
}

/// The surface of the last snapshot in space, if the run is of a body of rotation.
fn save_surface(
    run: &RunData,
    label: &RunLabel,
    around: u32,
    files: &mut Files,
) -> Result<(), FigureError> {
    let is_rotated = |snapshot: &&Snapshot| snapshot.mesh.geometry() == Geometry::Axisymmetric;
    if let Some(Snapshot { mesh, state, t, .. }) = run.snapshots.last().filter(is_rotated) {
        let stem = files.renamed(&label.file);
        let path = files.path(&format!("{stem}-surface"), "vtu");
        let contour = Contour::new(mesh, &state.phi);
        write_surface(&path, &contour, around, *t)?;
        files.written.push(path);
    }
    Ok(())
}

/// The files of a figure or of a set.
pub(super) struct Files {
    folder: PathBuf,
    /// What stands before the `-` or the point of the names, as asked for and as it is.
    stems: Vec<String>,
    suffix: String,
    replace: bool,
    /// What was written so far.
    pub written: Vec<PathBuf>,
}

impl Files {
    /// Makes the folder, and sees to it that no file of these names is lost.
    pub fn claim(
        folder: &Path,
        stems: Vec<String>,
        extensions: &[&str],
        options: &FigureOptions,
    ) -> Result<Files, FigureError> {
        make_folder(folder)?;
        let mut files = Files {
            folder: folder.to_owned(),
            stems,
            suffix: String::new(),
            replace: options.existing == Existing::Replace,
            written: Vec::new(),
        };
        let mut number = 1_u32;
        while let Some(path) = files.first_that_exists(extensions) {
            match options.existing {
                Existing::Replace => break,
                Existing::Refuse => return Err(FigureError::Occupied { path }),
                Existing::Number => {
                    number += 1;
                    files.suffix = format!("-{number}");
                }
            }
        }
        Ok(files)
    }

    fn first_that_exists(&self, extensions: &[&str]) -> Option<PathBuf> {
        let names = self.stems.iter().flat_map(|stem| {
            let stem = self.renamed(stem);
            extensions
                .iter()
                .map(move |extension| format!("{stem}.{extension}"))
        });
        names
            .map(|name| self.folder.join(name))
            .find(|path| path.symlink_metadata().is_ok())
    }

    fn renamed(&self, stem: &str) -> String {
        format!("{stem}{}", self.suffix)
    }

    pub fn stem(&self, number: usize) -> String {
        self.renamed(&self.stems[number])
    }

    fn path(&self, stem: &str, extension: &str) -> PathBuf {
        self.folder.join(format!("{stem}.{extension}"))
    }

    fn write(
        &mut self,
        stem: &str,
        extension: &str,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), FigureError> {
        let path = self.path(stem, extension);
        match self.replace {
            true => write_whole(&path, content)?,
            false => write_new(&path, content)?,
        }
        self.written.push(path);
        Ok(())
    }

    pub fn text(&mut self, stem: &str, extension: &str, text: &str) -> Result<(), FigureError> {
        self.write(stem, extension, |file| file.write_all(text.as_bytes()))
    }

    pub fn picture(
        &mut self,
        stem: &str,
        drawing: &Drawing,
        options: &FigureOptions,
        provenance: &Provenance,
    ) -> Result<(), FigureError> {
        let (width, height, dpi) = (drawing.width, drawing.height, options.dpi);
        let _claim = needs::picture(drawing)?;
        let picture = pixels::pixels(drawing)?;
        let file = png::encode(&picture, width, height, dpi, provenance)?;
        drop(picture);
        self.write(stem, "png", |out| out.write_all(&file))?;
        drop(file);
        self.text(
            stem,
            "svg",
            &svg::encode(drawing, options.svg_text, dpi, provenance)?,
        )
    }
}
