use super::keeper::{STEPS_WITH_ROWS, has_row};
use super::*;
use crate::record::RunMark;
use crate::record::atomic::size;
use crate::record::scene_file::tests::scene;
use crate::record::{Ending, IfOccupied, RecorderBuilder, Settings};
use crate::scene::AnchoringKind;
use crate::scene::Change;
use crate::simulation::{Report, Simulation};
use std::time::Duration;
use tempfile::TempDir;

struct Place {
    parent: TempDir,
    runs: KeptRuns,
    simulation: Simulation,
}

fn place() -> Place {
    let parent = tempfile::tempdir().unwrap();
    let scene = Arc::new(scene("[nematic]\n"));
    Place {
        runs: KeptRuns::new(&parent.path().join("unfinished"), "small", &scene),
        simulation: Simulation::new(&scene).unwrap(),
        parent,
    }
}

impl Place {
    fn advance(&mut self, keeper: &mut RunKeeper) {
        keeper.step(self.simulation.advance().unwrap());
    }

    fn keep(&self, keeper: &mut RunKeeper) -> PathBuf {
        let mut checkpoint = SimulationCheckpoint::default();
        self.simulation.save(&mut checkpoint);
        keeper.keep(checkpoint).unwrap();
        let kept = keeper.kept().expect("it is kept").clone();
        assert_eq!(kept.step, self.simulation.report().step);
        assert_eq!(kept.bytes, size(&kept.folder));
        kept.folder
    }

    /// A run of this many steps that is kept, by a process that has ended since.
    fn kept(&mut self, steps: usize) -> PathBuf {
        let mut keeper = self.runs.begin();
        keeper.step(self.simulation.report());
        for _ in 0..steps {
            self.advance(&mut keeper);
        }
        self.keep(&mut keeper)
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.parent.path().join("unfinished")).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

fn steps(rows: &Columns) -> Vec<f64> {
    rows.column("step").unwrap_or_default().to_vec()
}

fn notes(search: &Search) -> String {
    let notes: Vec<String> = search.notes.iter().map(ToString::to_string).collect();
    notes.join("\n")
}

#[test]
fn rows_are_thinned_out_so_that_they_grow_as_a_logarithm() {
    let rows = |from: u64, to: u64| (from..to).filter(|step| has_row(*step)).count() as u64;
    let full = STEPS_WITH_ROWS;
    assert_eq!(rows(0, full), full);
    assert_eq!(rows(full, 2 * full), full / 2);
    assert_eq!(rows(2 * full, 4 * full), full / 2);
    assert_eq!(rows(4 * full, 8 * full), full / 2);
}

#[test]
fn the_rows_after_the_state_are_taken_back_and_the_file_grows() {
    let mut place = place();
    let mut keeper = place.runs.begin();
    keeper.step(place.simulation.report());
    place.advance(&mut keeper);
    let folder = place.keep(&mut keeper);
    let text = || fs::read_to_string(folder.join("history.csv")).unwrap();
    let kept = text();
    place.advance(&mut keeper);
    keeper.flush().unwrap();
    assert!(text().starts_with(&kept) && text().len() > kept.len());
    drop(keeper);

    let search = place.runs.find();
    let run = search.run.as_ref().expect("it is kept");
    assert!(search.notes.is_empty(), "{}", notes(&search));
    assert_eq!((run.step(), run.folder()), (1, folder.as_path()));
    assert_eq!(steps(&run.rows().unwrap()), [0.0, 1.0]);
    // Looking for it changes nothing.
    assert!(text().len() > kept.len());
    let mut keeper = place.runs.go_on(run).unwrap();
    assert_eq!((text(), keeper.reached()), (kept, Some(1)));
    let again = scene("[nematic]\n");
    place.simulation = Simulation::new(&again).unwrap();
    place.simulation.restore(run.checkpoint()).unwrap();
    keeper.step(place.simulation.report());
    place.advance(&mut keeper);
    let set = Change::of_anchoring(AnchoringKind::Parallel);
    let change = place.simulation.change(set, 0.0).unwrap().clone();
    keeper.changed(&change).unwrap();
    place.simulation.advance().unwrap();
    let event = place.simulation.drain_events().pop().unwrap();
    keeper.mark(&event);
    keeper.step(place.simulation.report());
    assert_eq!(place.keep(&mut keeper), folder);
    let kept = fs::read_to_string(folder.join("scene.toml")).unwrap();
    assert!(kept.contains("[[change]]"), "{kept}");
    drop((keeper, search));
    let run = place.runs.find().run.expect("it is kept");
    assert_eq!(steps(&run.rows().unwrap()), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(run.marks(), [RunMark::of(&event).unwrap()]);
    assert_eq!(run.checkpoint().changes(), [change]);
    assert_eq!(place.names().len(), 1);
}

#[test]
fn the_state_does_not_grow_with_the_steps_and_every_step_has_its_row() {
    let mut place = place();
    let mut keeper = place.runs.begin();
    keeper.step(place.simulation.report());
    place.advance(&mut keeper);
    let folder = place.keep(&mut keeper);
    let bytes = || fs::metadata(folder.join("checkpoint.bin")).unwrap().len();
    let first = bytes();
    let report = place.simulation.report().clone();
    for step in 2..5000 {
        keeper.step(&Report {
            step,
            ..report.clone()
        });
    }
    place.keep(&mut keeper);
    assert!(bytes() <= first + 16, "{first} and then {}", bytes());
    let rows = steps(&Columns::read(&folder).unwrap());
    assert_eq!(rows, (0..5000).map(f64::from).collect::<Vec<_>>());
}

#[test]
fn the_runs_behind_the_first_are_named() {
    let mut place = place();
    let first = place.kept(1);
    assert!(place.runs.find().others.is_empty());
    let beside = [place.kept(1), place.kept(1)];
    // What has no state is not a kept run.
    fs::create_dir(format!("{}-4", first.display())).unwrap();
    let search = place.runs.find();
    assert_eq!(search.run.unwrap().folder(), first);
    assert_eq!(search.others, beside);
}

#[test]
fn a_table_that_another_program_has_rewritten_is_told_when_its_run_is_found() {
    let mut place = place();
    let folder = place.kept(2);
    let table = folder.join("history.csv");
    let text = fs::read_to_string(&table).unwrap();
    let rewritten = text.replace('\n', "\r\n");
    fs::write(&table, &rewritten).unwrap();
    let search = place.runs.find();
    assert!(
        matches!(&search.notes[..], [KeptNote::Tables { remarks }] if remarks.len() == 1),
        "{}",
        notes(&search)
    );
    assert!(notes(&search).contains("history.csv had been rewritten by another program"));
    // Looking for it changes nothing.
    assert_eq!(fs::read_to_string(&table).unwrap(), rewritten);
    drop(place.runs.go_on(&search.run.unwrap()).unwrap());
    assert_eq!(fs::read_to_string(&table).unwrap(), text);
    assert_eq!(notes(&place.runs.find()), "");
}

#[test]
fn a_run_has_one_process_and_a_second_one_a_folder_of_its_own() {
    let mut place = place();
    let first = place.kept(1);
    let held = place.runs.find();
    assert!(held.run.is_some());
    // Another process, or the same at another place: the lock is the folder's.
    let second = place.runs.find();
    assert!(second.run.is_none());
    assert!(
        matches!(&second.notes[..], [KeptNote::InUse { folder }] if *folder == first),
        "{}",
        notes(&second)
    );
    let beside = place.kept(1);
    assert_eq!(beside, PathBuf::from(format!("{}-2", first.display())));
    // While the first is in use the second can be resumed, and then the first again.
    assert_eq!(place.runs.find().run.unwrap().folder(), beside);
    drop(held);
    assert_eq!(place.runs.find().run.unwrap().folder(), first);
}

#[test]
fn what_is_put_aside_stays_whole_under_another_name() {
    let mut place = place();
    let first = place.kept(1);
    let run = place.runs.find().run.unwrap();
    let state = fs::read(first.join("checkpoint.bin")).unwrap();
    let aside = place.runs.put_aside(&run).unwrap();
    drop(run);
    assert_eq!(aside, PathBuf::from(format!("{}-2", first.display())));
    assert_eq!(fs::read(aside.join("checkpoint.bin")).unwrap(), state);
    assert_eq!(place.kept(2), first);
    assert_eq!(place.runs.find().run.unwrap().step(), 3);
    // It can still be opened by its folder, and continues there.
    let search = place.runs.find_in(&aside);
    let run = search.run.unwrap();
    assert_eq!(run.step(), 1);
    assert_eq!(place.runs.put_aside(&run).unwrap(), aside);
    let mut keeper = place.runs.go_on(&run).unwrap();
    assert_eq!(place.keep(&mut keeper), aside);
}

#[test]
fn a_run_of_another_scene_is_left_as_it_is() {
    let mut place = place();
    let folder = place.kept(1);
    let other = Arc::new(scene(""));
    let other = KeptRuns::new(&place.parent.path().join("unfinished"), "small", &other);
    let search = other.find_in(&folder);
    assert!(search.run.is_none());
    assert!(
        notes(&search).contains("of another scene"),
        "{}",
        notes(&search)
    );
    assert!(!notes(&search).contains("put aside"), "{}", notes(&search));
    assert_eq!(place.runs.find().run.unwrap().folder(), folder);
}

#[test]
fn a_damaged_state_is_put_aside_and_the_one_before_is_taken() {
    let mut place = place();
    let mut keeper = place.runs.begin();
    keeper.step(place.simulation.report());
    for _ in 0..2 {
        place.advance(&mut keeper);
        place.keep(&mut keeper);
    }
    let folder = keeper.kept().unwrap().folder.clone();
    drop(keeper);
    let newest = folder.join("checkpoint.bin");
    fs::write(&newest, "VESICAAP damaged").unwrap();
    let search = place.runs.find();
    let run = search.run.as_ref().expect("the one before");
    assert_eq!(run.step(), 1);
    assert_eq!(steps(&run.rows().unwrap()), [0.0, 1.0]);
    assert!(notes(&search).contains("checkpoint.bin cannot be used"));
    let aside = folder.join(DAMAGED);
    assert!(notes(&search).ends_with(&format!("put aside as {}", aside.display())));
    assert_eq!(fs::read(aside).unwrap(), b"VESICAAP damaged");
    assert!(!newest.exists());
    drop(search);

    fs::write(folder.join("checkpoint-older.bin"), "").unwrap();
    let search = place.runs.find();
    assert!(search.run.is_none());
    let aside = format!("{}-unusable", folder.display());
    assert!(
        notes(&search).contains("not a checkpoint") || notes(&search).contains("no checkpoint")
    );
    assert!(
        notes(&search).ends_with(&format!("put aside as {aside}")),
        "{}",
        notes(&search)
    );
    assert!(!folder.exists() && Path::new(&aside).join("history.csv").is_file());
    drop(search);
    assert_eq!(place.kept(1), folder);
}

#[test]
fn a_table_that_was_cut_is_told_and_the_run_goes_on_with_what_there_is() {
    let mut place = place();
    let folder = place.kept(2);
    let history = folder.join("history.csv");
    let text = fs::read_to_string(&history).unwrap();
    let two: String = text.split_inclusive('\n').take(2).collect();
    for (change, words, left) in [
        (two.as_str(), "2 of 3 rows are missing", vec![0.0]),
        (
            "step,t\n",
            "all 3 rows are missing; 12 columns are missing",
            vec![],
        ),
        ("\0rubbish", "cannot be read", vec![]),
    ] {
        fs::write(&history, change).unwrap();
        let search = place.runs.find();
        assert!(notes(&search).contains(words), "{}", notes(&search));
        let run = search.run.as_ref().expect("it goes on");
        assert_eq!((run.step(), steps(&run.rows().unwrap())), (2, left));
    }
    let search = place.runs.find();
    let kept = folder.join("history.csv.as-found");
    let words = format!("what was found is kept as {}", kept.display());
    assert!(notes(&search).ends_with(&words), "{}", notes(&search));
    let run = search.run.unwrap();
    let mut keeper = place.runs.go_on(&run).unwrap();
    assert_eq!(fs::read(kept).unwrap(), b"\0rubbish");
    keeper.step(place.simulation.report());
    place.advance(&mut keeper);
    place.keep(&mut keeper);
    drop((keeper, run));
    let search = place.runs.find();
    assert!(search.notes.is_empty(), "{}", notes(&search));
    assert_eq!(steps(&search.run.unwrap().rows().unwrap()), [3.0]);
    assert_eq!(place.names().len(), 1);
}

#[cfg(unix)]
#[test]
fn a_pipe_in_the_place_of_a_run_is_not_waited_for() {
    let mut place = place();
    let folder = place.kept(1);
    let pipe = |path: &Path| {
        let made = std::process::Command::new("mkfifo").arg(path).status();
        assert!(made.unwrap().success());
    };
    for file in ["history.csv", "shape.csv", "ledger.csv", "scene.toml"] {
        fs::remove_file(folder.join(file)).unwrap();
        pipe(&folder.join(file));
    }
    pipe(&PathBuf::from(format!("{}-2", folder.display())));
    let search = place.runs.find();
    assert!(
        notes(&search).contains("it is a pipe"),
        "{}",
        notes(&search)
    );
    assert_eq!(search.run.expect("it is found").step(), 1);
    fs::rename(&folder, folder.with_file_name("elsewhere")).unwrap();
    pipe(&folder);
    assert!(place.runs.find().run.is_none());
    assert!(place.runs.find_in(&folder).run.is_none());
    assert_eq!(
        place.kept(1),
        PathBuf::from(format!("{}-3", folder.display()))
    );
}

#[test]
fn a_folder_that_vanishes_is_made_anew_and_told() {
    let mut place = place();
    let mut keeper = place.runs.begin();
    keeper.step(place.simulation.report());
    place.advance(&mut keeper);
    let folder = place.keep(&mut keeper);
    fs::remove_dir_all(place.parent.path().join("unfinished")).unwrap();
    place.advance(&mut keeper);
    assert_eq!(place.keep(&mut keeper), folder);
    let lost = keeper.take_lost().expect("it is told").to_string();
    assert!(lost.contains("vanished"), "{lost}");
    drop(keeper);
    let run = place.runs.find().run.unwrap();
    assert_eq!((run.step(), steps(&run.rows().unwrap())), (2, vec![2.0]));
}

#[test]
fn what_cannot_be_written_is_an_error_and_written_as_soon_as_it_can_be() {
    let mut place = place();
    let parent = place.parent.path().join("unfinished");
    fs::write(&parent, "").unwrap();
    let mut keeper = place.runs.begin();
    keeper.step(place.simulation.report());
    place.advance(&mut keeper);
    let mut checkpoint = SimulationCheckpoint::default();
    place.simulation.save(&mut checkpoint);
    let error = keeper.keep(checkpoint).unwrap_err().to_string();
    assert!(error.contains("there is a file of this name"), "{error}");
    // What is saved on demand has all rows nevertheless.
    let copy = place.parent.path().join("copy");
    fs::create_dir(&copy).unwrap();
    keeper.rows().unwrap().unwrap().0.write(&copy).unwrap();
    assert_eq!(steps(&Columns::read(&copy).unwrap()), [0.0, 1.0]);
    fs::remove_file(&parent).unwrap();
    place.keep(&mut keeper);
    drop(keeper);
    let run = place.runs.find().run.unwrap();
    assert_eq!(steps(&run.rows().unwrap()), [0.0, 1.0]);
    assert!(!run.folder().join("ledger.csv").exists() || run.step() == 1);
}

#[test]
fn what_is_discarded_leaves_nothing_and_stays_away() {
    let mut place = place();
    let mut keeper = place.runs.begin();
    keeper.step(place.simulation.report());
    place.advance(&mut keeper);
    let folder = place.keep(&mut keeper);
    keeper.discard().unwrap();
    assert!(!folder.exists());
    place.advance(&mut keeper);
    keeper.keep(SimulationCheckpoint::default()).unwrap();
    assert_eq!(keeper.kept(), None);
    assert!(place.names().is_empty());
}

#[test]
fn a_recorded_run_is_found_up_to_its_checkpoint_and_left_as_it_is() {
    let mut place = place();
    let recorded = place.parent.path().join("recorded");
    let scene = place.runs.scene.clone();
    let search = place.runs.find_in(&recorded);
    assert!(matches!(&search.notes[..], [KeptNote::NoCheckpoint { .. }]));
    let settings = Settings {
        every: 2,
        ..Settings::default()
    };
    let run = RunFolder::at(&recorded, IfOccupied::Refuse).unwrap();
    let preparation = RecorderBuilder::begin(run, &scene, settings).unwrap();
    let mut recorder = preparation
        .start(&place.simulation, Duration::ZERO)
        .unwrap();
    for _ in 0..3 {
        place.simulation.advance().unwrap();
        recorder
            .step(&mut place.simulation, Duration::ZERO)
            .unwrap();
    }
    recorder
        .finish(&mut place.simulation, Ending::Interrupted("SIGTERM"))
        .unwrap();
    let read = || fs::read_to_string(recorded.join("history.csv")).unwrap();
    let text = read();
    let search = place.runs.find_in(&recorded);
    assert_eq!(notes(&search), "");
    let run = search.run.expect("a checkpoint");
    assert_eq!(run.step(), 3);
    // The last row was for the end: the checkpoint is before it.
    assert_eq!(steps(&run.rows().unwrap()), [0.0, 2.0]);
    let mut keeper = place.runs.go_on(&run).unwrap();
    place.simulation.advance().unwrap();
    keeper.step(place.simulation.report());
    let kept = place.keep(&mut keeper);
    assert_eq!(read(), text);
    assert_eq!(steps(&Columns::read(&kept).unwrap()), [0.0, 2.0, 4.0]);
    fs::write(recorded.join("history.csv"), text.replace('\n', "\r\n")).unwrap();
    drop(run);
    let search = place.runs.find_in(&recorded);
    assert!(search.run.is_some() && notes(&search).contains("rewritten by another program"));
    drop(search);
    let other = Arc::new(self::scene(""));
    let other = KeptRuns::new(place.parent.path(), "small", &other);
    let search = other.find_in(&recorded);
    assert!(search.run.is_none() && notes(&search).contains("another scene"));
}
