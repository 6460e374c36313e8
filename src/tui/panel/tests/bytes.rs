//! What a frame costs on the line.

use std::io::Write;
use std::sync::Arc;
use std::sync::Mutex;

use ratatui::backend::CrosstermBackend;
use ratatui::layout::Rect;
use ratatui::{Terminal, TerminalOptions, Viewport};

use super::made_up;
use crate::fem::Mesh;
use crate::geometry::{Point, Vector};
use crate::simulation::RunSnapshot;
use crate::tui::canvas::Canvas;
use crate::tui::panel::draw;
use crate::tui::theme::{ColorTier, Theme};

/// Counts what is written.
#[derive(Clone, Default)]
struct Counter(Arc<Mutex<usize>>);

impl Counter {
    fn take(&self) -> usize {
        std::mem::take(&mut self.0.lock().expect("one thread"))
    }
}

impl Write for Counter {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        *self.0.lock().expect("one thread") += bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Bytes of each frame of a vesicle that narrows its waist, turns its director and drifts to the
/// right while seven steps are taken a frame: what a run at Table 1's size does at most.
fn frames(theme: &Theme) -> Vec<usize> {
    let mesh = Arc::new(Mesh::structured(120, 0.0, 0).expect("a regular mesh"));
    let mut app = made_up::app();
    app.slots[2] = made_up::slot("case3", &mesh);
    let counter = Counter::default();
    let viewport = Viewport::Fixed(Rect::new(0, 0, 120, 40));
    let backend = CrosstermBackend::new(counter.clone());
    let mut terminal =
        Terminal::with_options(backend, TerminalOptions { viewport }).expect("it cannot fail");
    let mut canvas = Canvas::default();
    let mut sizes = Vec::new();
    for frame in 0..30_u64 {
        let run = made_up::run(&mut app);
        for step in 1..=7 {
            let report = made_up::report(made_up::STEPS + 7 * frame + step);
            run.history.take(&report);
            run.report = report;
        }
        // A twentieth of the domain in 30 frames: three of its samples.
        let time = frame as f64 / 30.0;
        let mut state = made_up::state(&mesh, time);
        let by = Vector::new(0.05 * time, 0.0);
        let nodes: Vec<Point> = mesh.nodes().iter().map(|node| node - by).collect();
        let triangles = mesh.triangles().to_vec();
        let shifted = Mesh::new(nodes, triangles).expect("as fair as before");
        state.phi = made_up::state(&shifted, time).phi;
        run.picture = Some(Arc::new(RunSnapshot {
            run: run.id,
            anchoring: None,
            report: run.report.clone(),
            mesh: mesh.clone(),
            state: Arc::new(state),
        }));
        terminal
            .draw(|frame| draw(&app, theme, &mut canvas, frame))
            .expect("it cannot fail");
        sizes.push(counter.take());
    }
    sizes
}

#[test]
fn a_moving_frame_has_at_most_six_kilobytes() {
    // One of the frames is the one in which the curves make room for twice as many steps.
    for tier in [ColorTier::True, ColorTier::Palette] {
        let sizes = frames(&Theme::new(tier, true));
        // The first one is the whole screen.
        let moving = &sizes[1..];
        assert!(
            moving.iter().all(|size| *size <= 6000),
            "{tier:?}: {sizes:?}"
        );
        assert!(
            moving.iter().all(|size| *size > 200),
            "nothing moved: {sizes:?}"
        );
    }
}
