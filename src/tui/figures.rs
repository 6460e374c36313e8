//! What the app saves as a report would have it: figures with their data, beside the states.

use std::sync::Arc;

use super::colour_map::COLOUR_MAPS;
use super::saving::{Job, What, save_states};
use super::state::{Field, View};
use crate::figure::{self, FigureOptions, RunData, Snapshot};
use crate::record::{Columns, RunFolder};
use crate::simulation::{Claim, RunSnapshot};

/// Saves figures: of a view PNG, SVG and CSV, beside its fields; of a set all figures of the run up to now, its
/// fields and its whole history. `scene.toml` stands beside them, and they say how they can be made
/// again.
///
/// # Errors
/// What could not be written or drawn, and why.
pub fn save_figures(job: &Job, folder: &RunFolder) -> Result<(), String> {
    save_states(job, folder)?;
    let files = match &job.what {
        What::View(picture, view) => save_view(job, picture, view, folder),
        What::Set(pictures, _) => {
            let claim = Claim::of(bytes_of_tables(folder));
            let _claim = claim.map_err(|shortage| format!("the set needs {shortage}"))?;
            let snapshots = pictures.iter().map(|picture| Snapshot {
                step: picture.report.step,
                t: picture.report.t,
                mesh: Arc::clone(&picture.mesh),
                state: Arc::clone(&picture.state),
            });
            let run = RunData {
                name: job.name.clone(),
                scene: Arc::clone(&job.scene),
                // What has just been written.
                history: Columns::read(folder.path()).map_err(|error| error.to_string())?,
                snapshots: snapshots.collect(),
                marks: job.marks.clone(),
                theory: job.theory.clone(),
                command: command(pictures.last().map_or(0, |last| last.report.step)),
            };
            figure::save_set(&[run], &FigureOptions::default(), folder.path())
        }
    };
    files.map(|_| ()).map_err(|error| error.to_string())
}

/// The tables of a set as text and as numbers.
fn bytes_of_tables(folder: &RunFolder) -> u64 {
    let size = |name| std::fs::metadata(folder.path().join(name)).map_or(0, |it| it.len());
    2 * (size("history.csv") + size("shape.csv"))
}

fn save_view(
    job: &Job,
    picture: &RunSnapshot,
    view: &View,
    folder: &RunFolder,
) -> Result<Vec<std::path::PathBuf>, figure::FigureError> {
    let steps = picture.report.step;
    let command = command(steps);
    let shown = figure::View {
        name: &job.name,
        scene: &job.scene,
        mesh: &picture.mesh,
        state: &picture.state,
        report: &picture.report,
        field: match view.field {
            Field::Phase => figure::Field::Phase,
            Field::EnergyDensity => figure::Field::BendingDensity {
                interface_width: job.scene.membrane.interface_width,
            },
            Field::DirectorLength => figure::Field::DirectorLength,
            Field::Omega => figure::Field::Bending,
            Field::Mu => figure::Field::Potential,
        },
        theory: job.theory.as_deref(),
        command: &command,
    };
    let options = FigureOptions {
        director: view.director,
        zoom: view.zoom,
        colours: COLOUR_MAPS[view.colour_map % COLOUR_MAPS.len()].figure,
        ..FigureOptions::view()
    };
    figure::save_view(&shown, &options, folder.path())
}

/// The commands that compute a run up to a step and draw it.
fn command(steps: u64) -> String {
    format!("vesica run scene.toml --steps {steps} --out run && vesica figures run")
}
