//! What the terminal sends and nobody typed.

use super::pty::Pty;
use super::{VESICA, folder, wait_running};
use std::thread::sleep;
use std::time::Duration;

#[test]
fn no_answer_of_the_terminal_and_no_paste_acts_as_a_key() {
    let folder = folder();
    let program = [VESICA, "small.toml"];
    let mut app = Pty::start((100, 30), folder.path(), &program, &[("EDITOR", "false")]);
    wait_running(&app);
    let long = format!("\x1b[200~{}2\x1b[201~", "x".repeat(1_048_700));
    let pieces = [
        // Answers to an earlier program: colours, attributes, the cursor's place, a name, graphics.
        "\x1b]11;rgb:1e1e/1e1e/2e2e\x1b\\",
        "\x1b]11;rgb:aaaa/aaaa/aaaa\x07",
        "\x1b[>41;320;0c\x1b[?62;4c\x1b[24;80R",
        "\x1bP>|XTerm(1234)e\x1b\\\x1b_Gi=2;e2341\x1b\\",
        "\x1bXe1234\x1b\\\x1b^e1234\x1b\\",
        // A slow link cuts them, and a paste, where it likes.
        "\x1b]11;rgb:1234/",
        "1234/1234\x1b",
        "\\\x1b[20",
        "0~2 hello\x1b[2",
        "01~\x1b",
        "[200~2341e\x1b[201~",
        &long,
        "\x1b[200~hello ",
    ];
    for piece in pieces {
        app.type_keys(piece);
        // Longer than anything that was waited for.
        sleep(Duration::from_millis(90));
    }
    sleep(Duration::from_millis(1200));
    app.type_keys("2\x1b[201~");
    // A key is one as ever.
    app.type_keys("q");
    app.wait_text("Leave vesica?");
    app.type_keys("y");
    app.assert_restored(0);
    let text = app.seen().text();
    assert!(text.contains("small: step "), "{text}");
    assert!(!text.contains("other run"), "{text}");
}

#[test]
fn an_answer_that_does_not_end_can_be_left() {
    let folder = folder();
    let program = [VESICA, "small.toml"];
    let mut app = Pty::start((100, 30), folder.path(), &program, &[]);
    wait_running(&app);
    app.type_keys("\x1b]11;qq");
    app.wait_text("Ctrl-C ends it");
    app.type_keys("qqq\x03q");
    app.wait_text("Leave vesica?");
    app.type_keys("y");
    app.assert_restored(0);
}
