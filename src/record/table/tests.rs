use super::*;

fn table(folder: &Path) -> Table {
    let columns = ["step", "t"].map(str::to_owned).to_vec();
    let mut table = Table::new(folder.join("table.csv"), columns);
    table.flush().unwrap();
    table
}

#[test]
fn grows_by_whole_lines_and_only_when_flushed() {
    let folder = tempfile::tempdir().unwrap();
    let mut table = table(folder.path());
    let text = |table: &Table| fs::read_to_string(&table.path).unwrap();
    assert_eq!(text(&table), "step,t\n");
    table.append([Some(0.0), Some(1e-7)]);
    table.append([Some(1.0), None]);
    assert_eq!(text(&table), "step,t\n");
    table.flush().unwrap();
    assert_eq!(text(&table), "step,t\n0,1e-7\n1,\n");
    table.append([None, Some(-2.5)]);
    table.finish().unwrap();
    assert_eq!(text(&table), "step,t\n0,1e-7\n1,\n,-2.5\n");
}

#[test]
fn a_late_column_is_empty_before() {
    let folder = tempfile::tempdir().unwrap();
    let mut table = table(folder.path());
    table.append([Some(0.0), Some(0.0)]);
    table.flush().unwrap();
    table.append([Some(0.5), Some(0.25)]);
    table.add_columns(vec!["E_field".into(), "E_pull".into()]);
    table.append([Some(1.0), Some(0.5), Some(3.0), None]);
    table.flush().unwrap();
    assert_eq!(
        fs::read_to_string(&table.path).unwrap(),
        "step,t,E_field,E_pull\n0,0,,\n0.5,0.25,,\n1,0.5,3,\n"
    );
}

#[test]
fn a_vanished_folder_is_an_error_with_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let mut table = table(folder.path());
    table.append([Some(0.0), Some(0.0)]);
    drop(folder);
    let error = table.flush().unwrap_err();
    assert!(matches!(&error, RecordError::Vanished { path } if *path == table.path));
    let error = table.flush().unwrap_err();
    assert!(matches!(&error, RecordError::Write { path, .. } if *path == table.path));
    // A folder that is created again gets the rows that were not lost.
    fs::create_dir(table.path.parent().unwrap()).unwrap();
    table.append([Some(1.0), Some(0.5)]);
    table.flush().unwrap();
    let text = fs::read_to_string(&table.path).unwrap();
    assert_eq!(text, "step,t\n0,0\n1,0.5\n");
    fs::remove_dir_all(table.path.parent().unwrap()).unwrap();
}

#[test]
fn a_table_is_taken_up_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let mut first = table(folder.path());
    first.append([Some(0.0), Some(0.0)]);
    first.append([Some(1.0), Some(0.5)]);
    first.flush().unwrap();
    let extent = first.extent();
    first.append([Some(2.0), Some(1.0)]);
    first.flush().unwrap();
    let path = first.path.clone();
    for late in [false, true] {
        if late {
            first.add_columns(vec!["late".into()]);
            first.append([Some(3.0), Some(1.5), Some(7.0)]);
            first.flush().unwrap();
        }
        let whole = fs::read_to_string(&path).unwrap();
        let found = Table::find(path.clone(), &extent);
        assert_eq!(fs::read_to_string(&path).unwrap(), whole);
        let remarks = found.remarks_of_take_up();
        assert!(remarks.is_empty(), "{remarks:?}");
        let mut again = found.reopen().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "step,t\n0,0\n1,0.5\n");
        again.append([Some(2.0), Some(1.0)]);
        again.flush().unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text, "step,t\n0,0\n1,0.5\n2,1\n");
        assert_eq!(again.extent().rows, 3);
        first = again;
    }
}

/// A table of four rows in a folder, and how far it goes.
fn four_rows(folder: &Path) -> (PathBuf, Extent) {
    let mut table = table(folder);
    for step in [0.0, 1.0, 2.0, 3.0] {
        table.append([Some(step), Some(step / 2.0)]);
    }
    table.flush().unwrap();
    (table.path.clone(), table.extent())
}

#[test]
fn a_table_that_is_cut_has_what_is_left_of_it() {
    let header = "step,t\n";
    for (text, left, words) in [
        (
            "step,t\n0,0\n1,0.5\n2,1\n",
            "0,0\n1,0.5\n2,1\n",
            "1 of 4 rows are missing, the last ones",
        ),
        (
            "step,t\n0,0\n1,0.5\n2,1\n3,1.",
            "0,0\n1,0.5\n2,1\n",
            "the last ones; line 5 is cut short",
        ),
        (
            "step,t\n0,0\n1,0.5\n",
            "0,0\n1,0.5\n",
            "2 of 4 rows are missing, the last ones",
        ),
        (
            "step,t\n0,0\n3,1.5\n",
            "0,0\n3,1.5\n",
            "2 of 4 rows are missing",
        ),
        (
            "step,t\n1,0.5\n2,1\n",
            "1,0.5\n2,1\n",
            "2 of 4 rows are missing, the last ones among them",
        ),
        (
            "step,t\n2,1\n3,1.5\n",
            "2,1\n3,1.5\n",
            "2 of 4 rows are missing, the first ones",
        ),
        ("step,t\n", "", "all 4 rows are missing"),
        ("step,t", "", "all 4 rows are missing"),
        ("", "", "is empty, and had 4 rows: a new one begins"),
        ("\n \n", "", "is empty, and had 4 rows: a new one begins"),
        (
            "step\n0\n1\n2\n3\n",
            "0,\n1,\n2,\n3,\n",
            "the column t is missing, and left empty",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let (path, extent) = four_rows(folder.path());
        fs::write(&path, text).unwrap();
        let found = Table::find(path.clone(), &extent);
        assert!(
            found.remarks()[0].contains(words),
            "{words}: {:?}",
            found.remarks()
        );
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
        let remarks = found.remarks_of_take_up();
        let mut again = found.reopen().unwrap();
        assert!(!remarks[0].contains("kept as"), "{remarks:?}");
        again.append([Some(4.0), Some(2.0)]);
        again.flush().unwrap();
        let wanted = format!("{header}{left}4,2\n");
        assert_eq!(fs::read_to_string(&path).unwrap(), wanted);
        // It is good again, as far as it goes.
        let found = Table::find(path, &again.extent());
        assert!(found.remarks().is_empty(), "{:?}", found.remarks());
    }
}

/// Nothing of the rows is lost, nor of what somebody wrote between them.
#[test]
fn what_is_left_out_of_a_table_is_kept_beside_it() {
    let rows = "0,0\n1,0.5\n2,1\n3,1.5\n";
    for (text, words) in [
        (
            "step,t\n0,0\n1,0.5\nhere it moves\n2,1\n3,1.5\n",
            "line 4 is left out: it has no step, and begins with \"here it moves\"; all its numbers are there",
        ),
        (
            "step,t\n0,0\n1,0.5\n2,1\n3,1.5\nhere it ends\n",
            "line 6 is left out",
        ),
        (
            "step,t\n0,0\n1,0.5\n2,1,here\n3,1.5\n",
            "line 4 has 3 cells, and those after the first 2 are left out; all its numbers",
        ),
        (
            "step,t,note\n0,0,here\n1,0.5,\n2,1,\n3,1.5,\n",
            "further ones",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let (path, extent) = four_rows(folder.path());
        fs::write(&path, text).unwrap();
        let found = Table::find(path.clone(), &extent);
        let remarks = found.remarks_of_take_up();
        found.reopen().unwrap();
        assert!(remarks[0].contains(words), "{words}: {remarks:?}");
        assert_eq!(
            fs::read_to_string(&path).unwrap(),
            format!("step,t\n{rows}")
        );
        let kept = folder.path().join("table.csv.as-found");
        assert!(remarks[0].ends_with(&format!("kept as {}", kept.display())));
        assert_eq!(fs::read_to_string(kept).unwrap(), text);
    }
}

#[test]
fn a_table_that_cannot_be_read_is_put_aside_and_begins_anew() {
    let folder = tempfile::tempdir().unwrap();
    let (path, extent) = four_rows(folder.path());
    let aside = |number: &str| folder.path().join(format!("table.csv.as-found{number}"));
    let put_aside = |words: &str, kept: &Path| {
        let found = Table::find(path.clone(), &extent);
        let remarks = found.remarks_of_take_up();
        let mut table = found.reopen().unwrap();
        assert_eq!(remarks.len(), 1);
        assert!(remarks[0].contains(words), "{words}: {remarks:?}");
        assert!(remarks[0].ends_with(&format!("kept as {}", kept.display())));
        table.append([Some(4.0), Some(2.0)]);
        table.flush().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "step,t\n4,2\n");
    };
    let rubbish = [0, 159, 146, 150, 255, 0, 0].repeat(1000);
    fs::write(&path, &rubbish).unwrap();
    put_aside("no line has the names of its columns", &aside(""));
    assert_eq!(fs::read(aside("")).unwrap(), rubbish);
    fs::remove_file(&path).unwrap();
    fs::create_dir(&path).unwrap();
    put_aside("it is a folder", &aside("-2"));
    assert!(aside("-2").is_dir());
}

#[test]
fn a_number_that_was_changed_is_told_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let (path, extent) = four_rows(folder.path());
    let found = |text: &str| {
        fs::write(&path, text).unwrap();
        Table::find(path.clone(), &extent).remarks().join("\n")
    };
    let told = found("step,t\n0,0\n1,0.5\n2,1.25\n3,1.5\n");
    assert!(
        told.contains("line 4, column t: the number is not the one that the run wrote"),
        "{told}"
    );
    // Other rows, and in another order.
    let told = found("step;t\n3;1.5\n2;1,25\n1;0,75\n0;0\n");
    assert!(
        told.contains("in the lines 3 and 4, column t: numbers are not those that the run wrote"),
        "{told}"
    );
    // Also of a table that was reopened.
    fs::write(&path, "step,t\n0,0\n1,0.5\n2,1\n3,1.5\n").unwrap();
    let mut table = Table::find(path.clone(), &extent).reopen().unwrap();
    table.append([Some(4.0), Some(2.0)]);
    table.flush().unwrap();
    let extent = table.extent();
    fs::write(&path, "step,t\n0,0\n1,0.5\n2,1\n3,1.5\n4,2.5\n").unwrap();
    let told = Table::find(path.clone(), &extent).remarks().join("\n");
    assert!(told.contains("line 6, column t: the number"), "{told}");
}

#[test]
fn a_row_that_a_disk_has_damaged_costs_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let (path, extent) = four_rows(folder.path());
    fs::write(&path, b"step,t\n0,0\n1,0\xff5\n2,1\n3,1.5\n").unwrap();
    let found = Table::find(path.clone(), &extent);
    let remarks = found.remarks_of_take_up();
    found.reopen().unwrap();
    let words = "line 3, column t had \"0\u{fffd}5\", which is no number";
    assert!(remarks[0].contains(words), "{remarks:?}");
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(text, "step,t\n0,0\n1,\n2,1\n3,1.5\n");
    // However much of rubbish there is.
    let text = format!("step,t\n0,0\n1,{}\n2,1\n3,1.5\n", "é".repeat(3 << 20));
    fs::write(&path, text).unwrap();
    let remarks = Table::find(path, &extent).remarks();
    assert!(remarks[0].len() < 400, "{} bytes", remarks[0].len());
}

#[test]
fn the_rows_of_a_moment_are_copied_while_the_table_grows() {
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("copy.csv");
    let text = || fs::read_to_string(&copy).unwrap();
    // In no file yet, in the file and not yet, and as columns come.
    let columns = ["step", "t"].map(str::to_owned).to_vec();
    let mut table = Table::new(folder.path().join("table.csv"), columns);
    table.append([Some(0.0), Some(0.0)]);
    table.rows_now().unwrap().write(&copy).unwrap();
    assert_eq!(text(), "step,t\n0,0\n");
    table.flush().unwrap();
    table.append([Some(1.0), Some(0.5)]);
    let extent = table.extent();
    let rows = table.rows_now().unwrap();
    table.append([Some(2.0), Some(1.0)]);
    table.add_columns(vec!["late".into()]);
    table.flush().unwrap();
    rows.write(&copy).unwrap();
    assert_eq!(text(), "step,t\n0,0\n1,0.5\n");
    // Of a table that was found.
    fs::remove_file(&copy).unwrap();
    let found = Table::find(table.path.clone(), &extent);
    found.rows().unwrap().write(&copy).unwrap();
    assert_eq!(text(), "step,t\n0,0\n1,0.5\n");
    let found = Table::find(table.path.clone(), &table.extent());
    found.rows().unwrap().write(&copy).unwrap();
    assert_eq!(text(), "step,t,late\n0,0,\n1,0.5,\n2,1,\n");
    table.add_columns(vec!["later".into()]);
    table.append([Some(3.0), None, None, Some(7.0)]);
    table.rows_now().unwrap().write(&copy).unwrap();
    assert!(text().ends_with("2,1,,\n3,,,7\n"), "{}", text());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_and_the_rows_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut table = table(folder.path());
    let full = OpenOptions::new().append(true).open("/dev/full").unwrap();
    let good = table.file.replace(full);
    table.append([Some(0.0), Some(0.0)]);
    let error = table.flush().unwrap_err().to_string();
    assert!(error.contains("table.csv: No space left"), "{error}");
    table.file = good;
    table.flush().unwrap();
    assert_eq!(fs::read_to_string(&table.path).unwrap(), "step,t\n0,0\n");
}
