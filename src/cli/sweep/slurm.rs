//! `vesica sweep slurm`: the points as job arrays of Slurm.

use super::results::left;
use super::{command, count_of, open, tell_same};
use crate::cli::error::CliError;
use crate::cli::figures::quoted;
use crate::cli::numbers;
use crate::cli::output;
use crate::record::{make_folder, write_new, write_whole};
use crate::study::sweep::{Point, SweepFolder, predict};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Tasks of an array where the cluster does not say: Slurm's own default of MaxArraySize.
const MAX_ARRAY_SIZE: usize = 1001;

/// The time limit over the predicted time: nodes are shared, and some are slower than others.
const TIME_FACTOR: f64 = 3.0;
/// Seconds that are added to it.
const TIME_MORE: f64 = 300.0;
/// The shortest time limit, in seconds: the signal before the limit comes up to three minutes early.
const LEAST_TIME: f64 = 600.0;
/// A run gets the signal to save this number of seconds before the time limit.
const SIGNAL_BEFORE: u32 = 120;

/// The memory that is requested over the predicted memory, and the bytes that are added to it.
const MEMORY_FACTOR: f64 = 1.3;
const MEMORY_MORE: f64 = 64e6;

/// Arguments of `vesica sweep slurm`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Writes scripts into DIR/slurm and submits them. What follows -- is given to sbatch as it is, and outweighs what \
the script says: -- --partition=long --time=1:00:00. A task that is preempted or comes near its time limit saves \
its run and has itself requeued; it goes on where it was. The command can be given again: it submits what is not \
done. `vesica sweep status DIR` tells how far it is; cancel with scancel.")]
pub(super) struct Arguments {
    /// The plan, or the folder of a sweep
    #[arg(value_name = "PLAN")]
    plan: PathBuf,

    /// The sweep's folder, on a file system that all nodes see
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Points a task, one after the other [default: as many as take some ten minutes]
    #[arg(long, value_name = "N", value_parser = numbers::count_from_one,
          allow_negative_numbers = true)]
    per_task: Option<u64>,

    /// So many tasks at a time, at most
    #[arg(long, value_name = "N", value_parser = numbers::count_from_one,
          allow_negative_numbers = true)]
    throttle: Option<u64>,

    /// Write the scripts and submit nothing
    #[arg(long)]
    dry_run: bool,

    /// Options of sbatch
    #[arg(last = true, value_name = "SBATCH OPTIONS")]
    options: Vec<String>,
}

/// Why jobs were not submitted.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SlurmError {
    /// The arguments do not go together.
    #[error("{reason}")]
    Arguments {
        /// Why.
        reason: String,
    },
    /// sbatch cannot be started.
    #[error(
        "sbatch cannot be started: {reason}. The scripts are in {}; submit them where Slurm is, or write them only, \
         with --dry-run",
        scripts.display()
    )]
    NoSbatch {
        /// What the system says.
        reason: io::Error,
        /// Where the scripts are.
        scripts: PathBuf,
    },
    /// sbatch refused.
    #[error("sbatch refused {}: {reason}", script.display())]
    Refused {
        /// The script.
        script: PathBuf,
        /// What sbatch says.
        reason: String,
    },
    /// Jobs of the sweep are queued.
    #[error(
        "the jobs {jobs} of this sweep are in the queue, and would do the same points; wait for them, or cancel \
         them with: scancel {jobs}"
    )]
    Queued {
        /// Their numbers.
        jobs: String,
    },
}

/// Writes the arrays, and submits them.
pub(super) fn slurm(arguments: &Arguments) -> Result<(), CliError> {
    let has_time = arguments
        .options
        .iter()
        .any(|option| option.starts_with("--time") || option.starts_with("-t"));
    if arguments.out.is_none() && !arguments.plan.is_dir() {
        let reason = "--out DIR is needed: the sweep's folder, on a file system that all nodes see"
            .to_owned();
        return Err(CliError::Slurm(SlurmError::Arguments { reason }));
    }
    let folder = open(&arguments.plan, arguments.out.as_deref(), true, |sweep| {
        match has_time {
            true => Ok(sweep.needs.clone()),
            // Nobody is there who might not want to wait: Ctrl-C ends the process.
            false => Ok(predict(sweep, &mut || true)?),
        }
    })?;
    tell_same(&folder);
    let slurm = folder.path().join("slurm");
    make_folder(&slurm)?;
    make_folder(&slurm.join("logs"))?;
    if !arguments.dry_run {
        refuse_queued(&slurm)?;
    }
    let points = left(&folder);
    if points.is_empty() {
        return output::line("there is nothing to submit: every point is done or running");
    }
    let tasks = tasks(&folder, &points, arguments.per_task);
    for tasks in tasks.chunks(max_array_size()) {
        let script = write_array(&folder, &slurm, tasks, arguments)?;
        if arguments.dry_run {
            output::line(format_args!(
                "{}: {} of {}; submit with: sbatch {}",
                script.display(),
                count_of(tasks.len(), "task"),
                count_of(tasks.iter().map(Vec::len).sum(), "point"),
                quoted(&script.to_string_lossy()),
            ))?;
            continue;
        }
        let job = submit(&script, &arguments.options, &slurm)?;
        output::line(format_args!(
            "job {job}: {} of {}",
            count_of(tasks.len(), "task"),
            count_of(tasks.iter().map(Vec::len).sum(), "point"),
        ))?;
    }
    if !arguments.dry_run {
        output::note(format_args!(
            "how far it is: vesica sweep status {0}; the table: vesica sweep table {0}",
            folder.path().display()
        ));
    }
    Ok(())
}

/// The time that a task is to take, in seconds, unless its number of points is given: starting a task costs the batch
/// system more than a shorter one would compute.
const TASK_SECONDS: f64 = 600.0;

/// The points of each task.
fn tasks<'a>(
    folder: &SweepFolder,
    points: &[&'a Point],
    per_task: Option<u64>,
) -> Vec<Vec<&'a Point>> {
    if let Some(count) = per_task {
        // Saturates.
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        return points.chunks(count).map(<[_]>::to_vec).collect();
    }
    let mut tasks: Vec<Vec<&Point>> = Vec::new();
    let mut left = 0.0;
    for &point in points {
        // Of what is not known, each is a task.
        let seconds = folder.needs(point).and_then(|needs| needs.seconds);
        let seconds = seconds.unwrap_or(TASK_SECONDS);
        match tasks.last_mut() {
            Some(task) if seconds <= left => {
                task.push(point);
                left -= seconds;
            }
            _ => {
                tasks.push(vec![point]);
                left = TASK_SECONDS - seconds;
            }
        }
    }
    tasks
}

/// Writes the script of an array, and the list of its tasks' points.
fn write_array(
    folder: &SweepFolder,
    slurm: &Path,
    tasks: &[Vec<&Point>],
    arguments: &Arguments,
) -> Result<PathBuf, CliError> {
    let number = (1..)
        .find(|number| !slurm.join(format!("array-{number}.sbatch")).exists())
        .unwrap_or(1);
    let list = slurm.join(format!("array-{number}.points"));
    let names = |task: &Vec<&Point>| {
        let names: Vec<&str> = task.iter().map(|point| &*point.name).collect();
        names.join(" ") + "\n"
    };
    let text: String = tasks.iter().map(names).collect();
    write_whole(&list, |file| file.write_all(text.as_bytes()))?;
    let script = slurm.join(format!("array-{number}.sbatch"));
    let text = script_text(folder, slurm, tasks, &list, arguments);
    write_new(&script, |file| file.write_all(text.as_bytes()))?;
    Ok(script)
}

fn script_text(
    folder: &SweepFolder,
    slurm: &Path,
    tasks: &[Vec<&Point>],
    list: &Path,
    arguments: &Arguments,
) -> String {
    let throttle = arguments
        .throttle
        .map_or(String::new(), |most| format!("%{most}"));
    let needs = |point: &&Point| folder.needs(point);
    let memory = tasks
        .iter()
        .flatten()
        .filter_map(needs)
        .map(|it| it.memory)
        .max();
    let memory = MEMORY_FACTOR * memory.unwrap_or(0) as f64 + MEMORY_MORE;
    let seconds = |task: &Vec<&Point>| -> Option<f64> {
        task.iter().map(|point| folder.needs(point)?.seconds).sum()
    };
    let longest: Option<Vec<f64>> = tasks.iter().map(seconds).collect();
    let time = longest
        .map(|all| all.into_iter().fold(0.0, f64::max))
        .map(|seconds| {
            let limit = (TIME_FACTOR * seconds + TIME_MORE).max(LEAST_TIME);
            format!("#SBATCH --time={}\n", (limit / 60.0).ceil() as u64)
        });
    let name: String = folder
        .title()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect();
    let path = |path: &Path| quoted(&path.to_string_lossy());
    SCRIPT
        .replace("@NAME@", &name)
        .replace("@LAST@", &(tasks.len() - 1).to_string())
        .replace("@THROTTLE@", &throttle)
        .replace("@TIME@", &time.unwrap_or_default())
        .replace("@MEMORY@", &format!("{}M", (memory / 1e6).ceil() as u64))
        .replace("@BEFORE@", &SIGNAL_BEFORE.to_string())
        .replace("@LOGS@", &slurm.join("logs").to_string_lossy())
        .replace("@LIST@", &path(list))
        .replace("@RUN@", command(folder, &[]).trim_end())
}

/// The script of a task. Slurm requeues neither what saves and exits when it is preempted, nor what reaches its time
/// limit: so the script asks for it. bash runs a trap only when its foreground program has ended, so the program runs in
/// the background.
const SCRIPT: &str = r#"#!/bin/bash
#SBATCH --job-name=@NAME@
#SBATCH --array=0-@LAST@@THROTTLE@
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --mem=@MEMORY@
@TIME@#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:TERM@@BEFORE@
#SBATCH --output=@LOGS@/%A_%a.log

# Each line of the list has the points of a task.
points=$(sed -n "$((SLURM_ARRAY_TASK_ID + 1))p" @LIST@)
echo "$(date -Is) task $SLURM_ARRAY_TASK_ID on $(hostname), start ${SLURM_RESTART_COUNT:-0}: $points"

child=
trap '[ -z "$child" ] || kill -TERM "$child" 2>/dev/null' TERM
@RUN@ $points &
child=$!
wait "$child"
status=$?
# A signal ends the wait, not the program.
while [ "$status" -gt 128 ] && kill -0 "$child" 2>/dev/null; do
    wait "$child"
    status=$?
done
if [ "$status" -gt 128 ]; then
    wait "$child" 2>/dev/null
    last=$?
    [ "$last" -eq 127 ] || status=$last
fi
echo "$(date -Is) task $SLURM_ARRAY_TASK_ID: status $status"

# 75: stopped by a signal, and saved.
if [ "$status" -eq 75 ]; then
    # It ends this script; where it is refused, the status says that there is more to do.
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}" && sleep 600
fi
exit "$status"
"#;

/// How many tasks an array may have.
fn max_array_size() -> usize {
    let config = Command::new("scontrol").args(["show", "config"]).output();
    let text = config.map_or_else(
        |_| String::new(),
        |it| String::from_utf8_lossy(&it.stdout).into(),
    );
    array_size(&text).unwrap_or(MAX_ARRAY_SIZE)
}

fn array_size(config: &str) -> Option<usize> {
    let line = config
        .lines()
        .find(|line| line.starts_with("MaxArraySize"))?;
    let size = line.split_once('=')?.1.trim().parse().ok()?;
    Some(size).filter(|size| *size > 0)
}

/// The list of what was submitted: a job's number a line.
const SUBMITTED: &str = "submitted.txt";

/// Submits a script; gives the job's number.
fn submit(script: &Path, options: &[String], slurm: &Path) -> Result<String, CliError> {
    let sbatch = Command::new("sbatch")
        .arg("--parsable")
        .args(options)
        .arg(script)
        .output();
    let output = sbatch.map_err(|reason| SlurmError::NoSbatch {
        reason,
        scripts: slurm.to_owned(),
    })?;
    if !output.status.success() {
        return Err(CliError::Slurm(SlurmError::Refused {
            script: script.to_owned(),
            reason: String::from_utf8_lossy(&output.stderr).trim().to_owned(),
        }));
    }
    // JOB or JOB;CLUSTER.
    let text = String::from_utf8_lossy(&output.stdout);
    let job = text.trim().split(';').next().unwrap_or_default().to_owned();
    let list = slurm.join(SUBMITTED);
    let before = fs::read_to_string(&list).unwrap_or_default();
    let all = format!("{before}{job}\n");
    write_whole(&list, |file| file.write_all(all.as_bytes()))?;
    Ok(job)
}

/// Refuses to submit while jobs of the same sweep are queued. Where squeue cannot be asked, the locks of the points
/// are left.
fn refuse_queued(slurm: &Path) -> Result<(), SlurmError> {
    let submitted = fs::read_to_string(slurm.join(SUBMITTED)).unwrap_or_default();
    let is_queued = |job: &&str| {
        let squeue = Command::new("squeue")
            .args(["-h", "-o", "%i", "-j", job])
            .output();
        squeue.is_ok_and(|output| output.status.success() && !output.stdout.trim_ascii().is_empty())
    };
    let jobs: Vec<&str> = submitted.lines().filter(is_queued).collect();
    match jobs.is_empty() {
        true => Ok(()),
        false => Err(SlurmError::Queued {
            jobs: jobs.join(" "),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_arrays_is_read() {
        let config = "MaxArraySize            = 1001\nMaxBatchRequeue = 5\n";
        assert_eq!(array_size(config), Some(1001));
        assert_eq!(array_size("MaxArraySize = 0\n"), None);
        assert_eq!(array_size(""), None);
    }
}
