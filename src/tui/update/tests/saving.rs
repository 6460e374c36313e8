//! One job that saves, and one that waits.

use std::path::PathBuf;

use super::super::super::message::{Effect, Message};
use super::super::super::state::{Overlay, Saving};
use super::rig::Rig;

fn with_picture() -> Rig {
    let mut rig = Rig::new();
    rig.work(5);
    rig.fetch();
    rig
}

#[test]
fn nothing_is_saved_before_there_is_anything() {
    let mut rig = Rig::new();
    rig.keys("sS");
    assert!(rig.effects.is_empty());
    assert!(rig.app.remark.clone().unwrap().contains("nothing to save"));
}

#[test]
fn one_is_saved_one_waits_and_a_third_is_refused() {
    let mut rig = with_picture();
    rig.keys("s");
    assert!(matches!(rig.effect(), Effect::SaveView(_, 2)));
    assert_eq!(
        rig.app.saving,
        Saving::Busy("the view of case3 at step 5".to_owned())
    );
    rig.keys("S");
    assert!(rig.effects.is_empty());
    rig.keys("s");
    assert!(rig.effects.is_empty());
    assert!(rig.app.remark.clone().unwrap().contains("already"));
    rig.tell(Message::Saved(Ok(PathBuf::from("/here/view.png"))));
    assert!(matches!(&rig.effects[..],
        [Effect::Copy(path), Effect::SaveSet(2)] if path == "/here/view.png"));
    assert_eq!(rig.app.remark.as_deref(), Some("saved /here/view.png"));
    assert!(matches!(&rig.app.saving, Saving::Busy(words) if words.contains("set of case3")));
    rig.effects.clear();
    rig.tell(Message::Saved(Ok(PathBuf::from("/here/set"))));
    assert!(matches!(rig.effect(), Effect::Copy(_)));
    assert_eq!(rig.app.saving, Saving::Saved(PathBuf::from("/here/set")));
    assert!(rig.app.saving_now.is_none() && rig.app.saving_next.is_none());
}

#[test]
fn what_fails_is_shown_with_its_reason_and_the_run_goes_on() {
    let mut rig = with_picture();
    rig.keys("s");
    rig.tell(Message::Saved(Err("the disk is full".to_owned())));
    assert_eq!(
        rig.app.saving,
        Saving::Failed("the disk is full".to_owned())
    );
    let step = rig.run(2).report.step;
    rig.work(2);
    assert!(rig.run(2).report.step > step);
}

#[test]
fn a_saved_set_need_not_be_asked_for_until_the_next_step() {
    let mut rig = with_picture();
    rig.keys(" ");
    rig.work(3);
    rig.keys("s");
    rig.tell(Message::Saved(Ok(PathBuf::from("view"))));
    assert!(rig.run(2).unsaved, "a view is not the whole run");
    rig.keys("S");
    rig.tell(Message::Saved(Ok(PathBuf::from("set"))));
    assert!(!rig.run(2).unsaved);
    rig.keys("n");
    rig.work(3);
    assert!(rig.run(2).unsaved);
    // Saved up to a step that is past by now.
    rig.keys("Sn");
    rig.work(3);
    rig.tell(Message::Saved(Ok(PathBuf::from("set"))));
    assert!(rig.run(2).unsaved);
    rig.keys("S");
    rig.tell(Message::Saved(Ok(PathBuf::from("set"))));
    rig.keys("r");
    assert!(!matches!(rig.app.overlay, Some(Overlay::Confirm(_))));
}
