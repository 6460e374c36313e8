//! What a scene and its effects cost, for the screen: measured beside the run that is shown.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::scene::Scene;
use crate::study::{Plan, price_words, prices, prices_table};

/// What the run of a scene would take on this machine, in words, or why it cannot be run; `load` gets it where
/// it is not given. `None`: `end` was set.
pub(super) fn expected(
    scene: Option<Arc<Scene>>,
    load: impl FnOnce() -> Result<Arc<Scene>, String>,
    end: &AtomicBool,
) -> Option<Result<String, String>> {
    let scene = match scene.map_or_else(load, Ok) {
        Ok(scene) => scene,
        // Its lines follow when it is opened.
        Err(reason) => return Some(Err(reason.lines().next().unwrap_or_default().to_owned())),
    };
    price_words(&scene, &mut || !end.load(Ordering::Relaxed))
}

/// Measures until it is done or `end` is set; reports its progress, and at last the table.
pub(super) fn measure(scene: &Scene, end: &AtomicBool, tell: &mut dyn FnMut(String)) {
    let mut told = 0;
    let outcome = prices(scene, Plan::default(), &mut |progress| {
        let percent = 100 * progress.done / progress.of.max(1);
        if percent > told {
            told = percent;
            tell(format!("measuring: {percent} % of {} steps", progress.of));
        }
        !end.load(Ordering::Relaxed)
    });
    match outcome {
        Ok(Some(prices)) => tell(format!(
            "{}\nMeasured beside the run: vesica effects measures without one.",
            prices_table(&prices)
        )),
        Ok(None) => {}
        Err(error) => tell(format!("the effects cannot be measured: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        let text = "mesh.cells = 8\nmembrane.interface_width = 0.1\n[area]";
        Scene::of_text(text, &[])
    }

    #[test]
    fn a_scene_that_cannot_be_loaded_is_told_with_its_reason() {
        let load = || Err("wrong.toml: unknown key 'sells'\n  --> line 2".to_owned());
        let words = expected(None, load, &AtomicBool::new(false));
        let first = Err("wrong.toml: unknown key 'sells'".to_owned());
        assert_eq!(words, Some(first));
    }

    #[test]
    fn the_table_comes_last() {
        let mut told = Vec::new();
        measure(&scene(), &AtomicBool::new(false), &mut |text| {
            told.push(text)
        });
        assert!(
            told[0].starts_with("measuring: 1 % of 90 steps"),
            "{}",
            told[0]
        );
        let last = told.last().expect("a table");
        assert!(
            last.contains("no area") && last.contains("bending alone"),
            "{last}"
        );
    }

    #[test]
    fn nothing_more_is_told_once_it_was_ended() {
        let mut told = Vec::new();
        measure(&scene(), &AtomicBool::new(true), &mut |text| {
            told.push(text)
        });
        assert!(told.len() <= 1, "{told:?}");
    }

    #[test]
    fn an_expectation_that_nobody_looks_at_is_given_up() {
        let scene = Some(Arc::new(scene()));
        let load = || Err("not asked for".to_owned());
        let expected = |end| expected(scene.clone(), load, &AtomicBool::new(end));
        assert_eq!(expected(true), None);
        assert!(matches!(expected(false), Some(Ok(words)) if words.starts_with("about ")));
    }
}
