//! `vesica export RUN`: a run as one file, for the supplement of a paper.

use super::error::CliError;
use super::figures;
use super::output;
use super::signals::EndSignal;
use crate::figure::{FigureOptions, save_set};
use crate::record::{
    CRATE_FILE, CrateDescription, CrateFile, LoadError, RecordError, RecordedSummary, Role,
    RunFolder, clean, files_of_run, read_run, read_summary, ro_crate, sha256, try_to_write,
    write_new, write_whole,
};
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Arguments of `vesica export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The file has the scene with its inputs, run.json, the tables, the fields, the figures, a README that says how to \
repeat the run, and ro-crate-metadata.json, which describes all of it by Process Run Crate 0.6. Unpacked it is a \
run's folder again: it can be opened, drawn, and compared with `vesica verify`. Checkpoints stay behind.")]
pub(super) struct Arguments {
    /// The folder of a run
    #[arg(value_name = "RUN", value_hint = clap::ValueHint::DirPath)]
    run: PathBuf,

    /// The file [default: NAME.zip, with the folder's name]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Whose run it is
    #[arg(long, value_name = "NAME")]
    author: Option<String>,

    /// The licence of the data, such as `https://creativecommons.org/licenses/by/4.0/`
    #[arg(long, value_name = "URL", value_parser = url)]
    license: Option<String>,

    /// Draw no figures
    #[arg(long)]
    no_figures: bool,

    /// Replace the file, if it is there
    #[arg(long)]
    force: bool,
}

fn url(text: &str) -> Result<String, String> {
    let rest = text
        .strip_prefix("https://")
        .or(text.strip_prefix("http://"));
    let is_one = rest.is_some_and(|rest| !rest.is_empty() && !rest.contains(char::is_whitespace));
    is_one.then(|| text.to_owned()).ok_or_else(|| {
        "it must be a URL, such as https://creativecommons.org/licenses/by/4.0/".into()
    })
}

/// A file that is packed: its place in the archive, and on the disk.
struct Packed {
    path: String,
    role: Role,
    source: PathBuf,
}

/// Packs the run.
pub(super) fn export(arguments: &Arguments) -> Result<(), CliError> {
    let run = &arguments.run;
    let summary = read_summary(run)?;
    if RunFolder::is_in_use(run) {
        return Err(CliError::Load(LoadError::InUse {
            folder: run.clone(),
        }));
    }
    // Of `.` and `..` the name is that of the folder behind them.
    let whole = run.canonicalize().unwrap_or_else(|_| run.clone());
    let name = whole.file_name().unwrap_or("run".as_ref());
    let name = name.to_string_lossy().into_owned();
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| PathBuf::from(format!("{name}.zip")));
    if out.exists() && !arguments.force {
        return Err(CliError::Exists { path: out });
    }
    let signal = EndSignal::listen()?;
    // What an export that was killed had left there.
    clean(match out.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    });
    try_to_write(&out)?;
    let go_on = || match signal.received() {
        Some(signal) => Err(CliError::ExportEnded(signal)),
        None => Ok(()),
    };
    let temporary = tempfile::tempdir().map_err(|reason| RecordError::MakeFolder {
        path: std::env::temp_dir(),
        reason,
    })?;
    let mut packed: Vec<Packed> = files_of_run(run)
        .into_iter()
        .map(|(path, is_input)| Packed {
            source: run.join(&path),
            role: if is_input { Role::Input } else { Role::Record },
            path,
        })
        .collect();
    if !arguments.no_figures {
        packed.extend(figures_of(run, &name, &temporary.path().join("figures"))?);
    }
    output::doubts(run, &summary);
    go_on()?;
    let readme = temporary.path().join("README.md");
    write_whole(&readme, |file| {
        file.write_all(readme_of(&summary, &name).as_bytes())
    })?;
    packed.push(Packed {
        path: "README.md".to_owned(),
        role: Role::Words,
        source: readme,
    });
    let mut files: Vec<CrateFile> = Vec::new();
    for file in &packed {
        go_on()?;
        files.push(described(file)?);
    }
    let description = CrateDescription {
        files: &files,
        date: &today(),
        author: arguments.author.as_deref(),
        license: arguments.license.as_deref(),
    };
    let description = ro_crate(&summary, &description);
    let content = |file: &mut dyn Write| {
        let text = serde_json::to_string_pretty(&description)?;
        pack(file, text.as_bytes(), &packed, &signal)
    };
    let written = match arguments.force {
        true => write_whole(&out, content),
        false => write_new(&out, content),
    };
    if written.is_err() {
        // It may be that of the signal; what was written is removed.
        go_on()?;
    }
    written?;
    output::summary(format_args!(
        "{} files of {}, with a description, in {}",
        files.len(),
        run.display(),
        out.display()
    ))
}

/// Draws the figures of a run into a folder; none where there are no fields.
fn figures_of(run: &Path, name: &str, folder: &Path) -> Result<Vec<Packed>, CliError> {
    let command = format!("vesica figures {}", figures::quoted(name));
    let Some(data) = figures::data((name.to_owned(), read_run(run)?), &command, false) else {
        return Ok(Vec::new());
    };
    let files = save_set(&[data], &FigureOptions::default(), folder)?;
    let packed = files.into_iter().filter_map(|source| {
        let file = source.file_name()?.to_string_lossy().into_owned();
        Some(Packed {
            path: format!("figures/{file}"),
            role: Role::Figure,
            source,
        })
    });
    Ok(packed.collect())
}

fn described(packed: &Packed) -> Result<CrateFile, RecordError> {
    let read = |reason| RecordError::Read {
        path: packed.source.clone(),
        reason,
    };
    Ok(CrateFile {
        path: packed.path.clone(),
        role: packed.role,
        size: fs::metadata(&packed.source).map_err(read)?.len(),
        sha256: sha256(&packed.source).map_err(read)?,
    })
}

/// Writes the archive. Its files have no dates: the same run is the same file, but for the day of the export.
fn pack(
    to: &mut dyn Write,
    description: &[u8],
    packed: &[Packed],
    signal: &EndSignal,
) -> io::Result<()> {
    let mut archive = ZipWriter::new_stream(to);
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(zip::DateTime::default())
        .unix_permissions(0o644)
        .large_file(true);
    archive.start_file(CRATE_FILE, options)?;
    archive.write_all(description)?;
    for file in packed {
        archive.start_file(file.path.as_str(), options)?;
        let source = File::open(&file.source)?;
        io::copy(&mut Stoppable { source, signal }, &mut archive)?;
    }
    archive.finish()?;
    Ok(())
}

/// A file that is read until a signal comes.
struct Stoppable<'a> {
    source: File,
    signal: &'a EndSignal,
}

impl Read for Stoppable<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.signal.received() {
            Some(_) => Err(io::Error::other("the export was ended")),
            None => self.source.read(buffer),
        }
    }
}

/// The day, in UTC.
fn today() -> String {
    let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    now.chars().take("2026-11-26".len()).collect()
}

/// What the archive says to a reader.
fn readme_of(summary: &RecordedSummary, name: &str) -> String {
    let mut text = format!(
        "# A run of vesica: {}\n\n\
         A vesicle with nematic order inside, simulated by vesica {}: {} steps.\n\n\
         | file | content |\n| --- | --- |\n\
         | `scene.toml` | the complete scene, with its files in `inputs/` if it has any |\n\
         | `history.csv`, `ledger.csv`, `shape.csv` | energies, the energy law, and the size of the vesicle, step by step |\n\
         | `fields/`, `final.vtu` | the fields, for ParaView |\n\
         | `figures/` | figures of the run, if it left fields |\n\
         | `run.json` | how the run went: by which programs, on which computers, from which inputs (SHA-256) |\n\
         | `ro-crate-metadata.json` | all of this for programs: RO-Crate 1.3, Process Run Crate 0.6 |\n\n",
        summary.scene,
        summary
            .sessions
            .last()
            .map_or("of unknown version", |session| &session.program.version),
        summary.steps,
    );
    text += "## How to repeat it\n\nUnpack this file into a folder of its own, here called `";
    text += name;
    text += "`. The first command computes the run again and compares it with the one here; the second only runs it.\n\n";
    text += &format!(
        "    vesica verify {0}\n    vesica run {0}/scene.toml\n\n",
        figures::quoted(name)
    );
    if let Some(session) = summary.sessions.last() {
        let program = &session.program;
        let known = |text: &Option<String>| text.clone().unwrap_or_else(|| "unknown".to_owned());
        text += &format!(
            "It was computed by vesica {}, commit {}{}, compiled by {} for {}. The same program gives the same numbers \
             bit for bit, in any number of threads; another compiler or processor may differ in the last digits.\n",
            program.version,
            known(&program.commit),
            if program.changed == Some(true) {
                " (changed)"
            } else {
                ""
            },
            known(&program.compiler),
            program.target,
        );
    }
    text
}
