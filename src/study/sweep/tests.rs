//! Plans as a user writes them: what they give, and what is refused.

use super::*;
use std::fs;
use std::path::Path;

const SCENE: &str = "\
name = \"Small\"
[mesh]
cells = 8
[time]
step = 1e-7
end = 3e-7
[membrane]
interface_width = 0.05
[area]
target = 1.1
[nematic]
[anchoring]
kind = \"parallel\"
";

fn read(folder: &Path, plan: &str) -> Result<Sweep, SweepError> {
    fs::write(folder.join("small.toml"), SCENE).expect("written");
    let path = folder.join("plan.toml");
    fs::write(&path, format!("scene = \"small.toml\"\n{plan}")).expect("written");
    Sweep::read(&path)
}

#[track_caller]
fn sweep(plan: &str) -> Sweep {
    let folder = tempfile::tempdir().expect("a folder");
    read(folder.path(), plan).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn refused(plan: &str, parts: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    let error = read(folder.path(), plan)
        .expect_err("it is wrong")
        .to_string();
    for part in parts {
        assert!(error.contains(part), "no '{part}' in: {error}");
    }
}

fn values(sweep: &Sweep) -> Vec<Vec<&str>> {
    sweep
        .points
        .iter()
        .map(|point| point.values.iter().map(String::as_str).collect())
        .collect()
}

#[test]
fn lists_ranges_and_nested_keys_make_every_combination() {
    let sweep = sweep(
        "[vary]\n\"area.target\" = { from = 0.9, to = 1.1, count = 3 }\n\
         anchoring.weight = { from = 1, to = 100, count = 3, scale = \"log\" }\n\
         [vary.anchoring]\nkind = [\"parallel\", 'homeotropic']\n"
            .replace("anchoring.weight = {", "\"anchoring.weight\" = {")
            .as_str(),
    );
    assert_eq!(sweep.points.len(), 18);
    let all = values(&sweep);
    assert_eq!(all[0], ["0.9", "1", "\"parallel\""]);
    assert_eq!(all[1], ["0.9", "1", "'homeotropic'"]);
    assert_eq!(all[2], ["0.9", "10", "\"parallel\""]);
    assert_eq!(all[17], ["1.1", "100", "'homeotropic'"]);
    assert_eq!(all[6][0], "1");
    let scene = sweep.scene(&sweep.points[17]).expect("right");
    assert_eq!(scene.area.map(|area| area.target), Some(1.1));
    let names: Vec<&str> = sweep.points.iter().map(|it| &it.name[..5]).collect();
    assert_eq!((names[0], names[17]), ("0001-", "0018-"));
}

#[test]
fn zipped_keys_go_together_and_single_points_come_last() {
    let sweep = sweep(
        "[vary]\n\"area.target\" = [0.9, 1.0]\n\
         zip = [{ \"mesh.cells\" = [8, 12, 16], time.step = { from = 3e-7, to = 1e-7, count = 3 } }]\n\
         [[point]]\n\"anchoring.weight\" = 3\n[[point]]\nmesh = { cells = 10 }\n",
    );
    let all = values(&sweep);
    assert_eq!(all.len(), 8);
    assert_eq!(all[1], ["0.9", "12", "2e-7", "10.1"]);
    assert_eq!(all[5], ["1.0", "16", "1e-7", "10.1"]);
    // What a single point does not say is the scene's own.
    assert_eq!(all[6], ["1.1", "8", "1e-7", "3"]);
    assert_eq!(all[7], ["1.1", "10", "1e-7", "10.1"]);
}

#[test]
fn the_same_scene_is_found_and_repetitions_have_seeds() {
    let sweep =
        sweep("[vary]\n\"area.target\" = [1, 1.1, 1.0]\n[[point]]\n\"area.target\" = 1.1\n");
    let same: Vec<Option<usize>> = sweep.points.iter().map(|it| it.same_as).collect();
    assert_eq!(same, [None, None, Some(1), Some(2)]);

    let repeated = "repeat = { count = 3, seeds = [\"noise.seed\"], first = 7 }\n\
                    set = { noise = { strength = 1e-3 } }\n[vary]\n\"area.target\" = [1, 1.1]\n";
    let sweep = self::sweep(repeated);
    assert_eq!(sweep.points.len(), 6);
    let last = &sweep.points[5];
    assert_eq!(last.repetition, 3);
    let scene = sweep.scene(last).expect("right");
    assert_eq!(scene.noise.map(|noise| noise.seed), Some(9));
    let all = self::sweep("repeat = 2\n[set]\n\"noise.strength\" = 1e-3\n\"mesh.jitter\" = 0.1\n");
    let keys: Vec<&str> = all.points[1]
        .assignments
        .iter()
        .map(|it| &*it.key)
        .collect();
    assert_eq!(keys.len(), 2, "{keys:?}");
    refused("repeat = 2\n", &["needs a seed", "noise.seed"]);
}

#[test]
fn mistakes_are_reported_with_place_near_miss_and_the_points_values() {
    refused(
        "[vary]\n\"anchoring.wieght\" = [1]\n",
        &["plan.toml:3:1", "did you mean 'weight'"],
    );
    refused("[vray]\n", &["unknown key 'vray'", "did you mean 'vary'"]);
    refused(
        "[vary]\narea.target = 3\n",
        &["vary.area.target must be a list"],
    );
    refused("[vary]\narea.target = []\n", &["at least one value"]);
    refused(
        "[vary]\n\"area.target\" = { from = 1, to = 2 }\n",
        &["needs the key 'count'"],
    );
    refused(
        "[vary]\n\"area.target\" = { from = 0, to = 2, count = 3, scale = \"log\" }\n",
        &["a number > 0, for the scale is logarithmic"],
    );
    refused(
        "[vary]\n\"area.target\" = { from = 1, to = 2, count = 3, scale = \"lag\" }\n",
        &["did you mean 'log'"],
    );
    refused(
        "[vary]\nzip = [{ \"area.target\" = [1, 2], \"anchoring.weight\" = [1] }]\n",
        &["of 2 values, as many as area.target has"],
    );
    refused(
        "[vary]\n\"area.target\" = [1]\narea.target = [2]\n",
        &["area.target is given more than once"],
    );
    refused("[result]\na = \"min(wasit)\"\n", &["did you mean 'waist'"]);
    refused("[result]\na = \"least(waist)\"\n", &["time_of_min"]);
    refused(
        "[vary]\n\"area.target\" = [1, -1]\n\"anchoring.weight\" = [1, \"much\"]\n",
        &[
            "point 2 (area.target = 1, anchoring.weight = \"much\")",
            "point 3 (area.target = -1, anchoring.weight = 1)",
            "3 of 4 points cannot be run; nothing was started",
        ],
    );
    refused(
        "[vary]\n\"vesicle.center\" = [[9.0, 9.0]]\n",
        &["point 1", "outside of the domain"],
    );
    refused(
        "[vary]\n\"time.end\" = [1e-9, 3e-7]\n",
        &["point 1 (time.end = 1e-9)", "before the first step"],
    );
    refused(
        "[vary]\n\"area.target\" = { from = 1, to = 2, count = 1000 }\n\
         \"anchoring.weight\" = { from = 1, to = 2, count = 1000 }\n",
        &["1000000 points; at most 100000"],
    );
}

#[test]
fn mistakes_of_the_plan_itself_have_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("plan.toml");
    fs::write(&path, "name = \"A\"\nscene = \"nope\"\n").expect("written");
    let error = Sweep::read(&path).expect_err("no scene").to_string();
    assert!(
        error.contains("plan.toml:2:9: the plan's scene: there is no file"),
        "{error}"
    );
    refused(
        "[set]\n\"time.end\" = -1\n",
        &["plan.toml:3:14: time.end must be", "3 | \"time.end\" = -1"],
    );
    refused(
        "[set.time]\nend = -1\n",
        &["plan.toml:3:7: time.end must be"],
    );
    refused("repeat = 2\n", &["plan.toml:2:10: repeat needs a seed"]);
    let many = "[vary]\n\"area.target\" = { from = 1, to = 2, count = 1000 }\n\
         \"anchoring.weight\" = { from = 1, to = 2, count = 1000 }\n";
    refused(many, &["plan.toml:2:", "at most 100000"]);
    // A mistake in the file of the scene has the place in that file.
    fs::write(&path, "scene = \"wrong.toml\"\n").expect("written");
    fs::write(folder.path().join("wrong.toml"), "[area]\ntarget = -1\n").expect("written");
    let error = Sweep::read(&path).expect_err("wrong").to_string();
    assert!(
        error.contains("wrong.toml:2:10: area.target must be"),
        "{error}"
    );
}

/// No seed is made up for a scene that has none, and what is wrong is told once for all repetitions.
#[test]
fn a_wrong_point_that_is_repeated_is_told_as_the_plan_has_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = "repeat = 4\n[vary]\n\"area.target\" = [-1, -2]\n";
    let error = read(folder.path(), plan).expect_err("wrong").to_string();
    assert!(error.contains("point 1 (area.target = -1): "), "{error}");
    assert!(error.contains("point 5 (area.target = -2): "), "{error}");
    assert!(error.contains("8 of 8 points cannot be run"), "{error}");
    for part in ["seed", "point 2", "more"] {
        assert!(!error.contains(part), "{error}");
    }
}

#[test]
fn columns_have_names_of_their_own() {
    for name in [
        "point",
        "state",
        "repetition",
        "waist",
        "t",
        "E_total",
        "E_bending",
        "E_field",
        "\"waist/length\"",
    ] {
        refused(
            &format!("[result]\n{name} = \"min(waist)\"\n"),
            &["plan.toml:3:1: the table has a column", "already"],
        );
    }
    refused(
        "[vary]\n\"area.target\" = [1, 2]\n[result]\n\"area.target\" = \"min(waist)\"\n",
        &["plan.toml:5:1: the table has a column 'area.target' already"],
    );
    sweep("[result]\nthinnest = \"min(waist)\"\nE_least = \"min(E_total)\"\n");
}

#[test]
fn only_seeds_are_repeated() {
    let repeat = |seeds: &str| format!("repeat = {{ count = 2, seeds = [{seeds}] }}\n");
    refused(
        &repeat("\"time.step\""),
        &["plan.toml:2:32: repeat.seeds[0] must be the key of a seed"],
    );
    refused(
        &repeat("\"noise.seed\", \"noise.seed\""),
        &["noise.seed is given more than once"],
    );
    sweep(&format!(
        "{}[set]\n\"noise.strength\" = 1e-3\n",
        repeat("\"noise.seed\"")
    ));
}

/// The folder is enough: a point's scene is the same as the plan's, and changes are noticed.
#[test]
fn a_folder_keeps_the_sweep() {
    let here = tempfile::tempdir().expect("a folder");
    let sweep = read(here.path(), "[vary]\n\"area.target\" = [0.9, 1.0]\n").expect("right");
    let needs = sweep.needs.clone();
    let path = here.path().join("out");
    let folder = SweepFolder::create(&path, &sweep, needs).expect("written");
    for (point, own) in folder.points().iter().zip(&sweep.points) {
        assert_eq!(point, own);
        let scene = folder.scene(point).expect("right");
        assert_eq!(scene, sweep.scene(own).expect("right"));
        assert_eq!(folder.state(point), PointState::Waiting);
    }
    let error = SweepFolder::create(&path, &sweep, Vec::new()).expect_err("there");
    assert!(matches!(error, SweepError::Occupied { .. }));
    let left_behind = [
        ".vesica-a.part",
        "base/.vesica-b.part",
        "points/.vesica-c.part",
    ];
    for name in left_behind {
        fs::write(path.join(name), "half").expect("written");
    }
    assert!(SweepFolder::resume(&path, &sweep).is_ok());
    for name in left_behind {
        assert!(
            !path.join(name).exists(),
            "{name} of a process that was killed"
        );
    }
    let other = read(here.path(), "[vary]\n\"area.target\" = [0.9, 1.1]\n").expect("right");
    let error = SweepFolder::resume(&path, &other).expect_err("changed");
    assert!(error.to_string().contains("0002-"), "{error}");
    let table = Table::read(&folder).to_csv();
    assert!(
        table.starts_with("area.target,point,state,step,t,"),
        "{table}"
    );
    assert_eq!(table.lines().count(), 3);
}

#[test]
fn a_large_plan_is_checked_too() {
    let sweep = sweep(
        "[vary]\n\"area.target\" = { from = 0.9, to = 1.4, count = 40 }\n\
         \"anchoring.weight\" = { from = 1, to = 100, count = 30, scale = \"log\" }\n",
    );
    assert_eq!(sweep.points.len(), 1200);
}
