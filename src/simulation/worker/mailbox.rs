//! Where the latest picture of a run waits to be fetched.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::super::Report;
use super::RunSnapshot;
use crate::fem::Mesh;
use crate::scheme::State;

/// Room for one picture: a new one takes the place of one that nobody has fetched.
#[derive(Debug, Clone, Default)]
pub struct Mailbox(Arc<Mutex<Option<Arc<RunSnapshot>>>>);

impl Mailbox {
    /// Takes out the latest picture, if there is one since the last call.
    pub fn fetch(&self) -> Option<Arc<RunSnapshot>> {
        self.place().take()
    }

    /// Whether the last picture was fetched.
    pub(super) fn is_empty(&self) -> bool {
        self.place().is_none()
    }

    pub(super) fn put(&self, picture: Arc<RunSnapshot>) {
        *self.place() = Some(picture);
    }

    /// Held for an assignment only, so neither side ever waits for the other's work.
    fn place(&self) -> MutexGuard<'_, Option<Arc<RunSnapshot>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Pictures that are painted over when nobody else holds them any more: one is shown, one waits in
/// the mailbox, one is painted.
#[derive(Debug, Default)]
pub(super) struct SnapshotPool(Vec<Arc<RunSnapshot>>);

const CANVASES: usize = 3;

impl SnapshotPool {
    /// A copy of `picture` in a canvas that is free, or in a new one. A canvas that is kept
    /// elsewhere (an older state to look back at) stays with its holder.
    pub(super) fn paint(&mut self, picture: SnapshotOf<'_>) -> Arc<RunSnapshot> {
        let free = self
            .0
            .iter_mut()
            .position(|canvas| Arc::get_mut(canvas).is_some());
        if let Some(mut canvas) = free.map(|index| self.0.remove(index)) {
            if let Some(canvas) = Arc::get_mut(&mut canvas) {
                picture.paint_over(canvas);
            }
            self.0.push(canvas);
        } else {
            if self.0.len() == CANVASES {
                self.0.remove(0);
            }
            self.0.push(Arc::new(picture.to_picture()));
        }
        self.0[self.0.len() - 1].clone()
    }
}

/// What a picture is made of, by reference.
#[derive(Debug, Clone, Copy)]
pub(super) struct SnapshotOf<'a> {
    pub(super) run: super::RunId,
    pub(super) anchoring: Option<crate::scene::AnchoringKind>,
    pub(super) report: &'a Report,
    pub(super) mesh: &'a Arc<Mesh>,
    pub(super) state: &'a State,
}

impl SnapshotOf<'_> {
    pub(super) fn to_picture(self) -> RunSnapshot {
        RunSnapshot {
            run: self.run,
            anchoring: self.anchoring,
            report: self.report.clone(),
            mesh: self.mesh.clone(),
            state: Arc::new(self.state.clone()),
        }
    }

    /// The same without allocating: the vectors have their lengths, unless a figure still holds the fields.
    fn paint_over(self, picture: &mut RunSnapshot) {
        picture.run = self.run;
        picture.anchoring = self.anchoring;
        picture.mesh.clone_from(self.mesh);
        let mut energies = std::mem::take(&mut picture.report.energies);
        let mut ledger = std::mem::take(&mut picture.report.ledger);
        energies.clone_from(&self.report.energies);
        ledger.clone_from(&self.report.ledger);
        let mut vesicles = std::mem::take(&mut picture.report.vesicles);
        vesicles.clone_from(&self.report.vesicles);
        picture.report = Report {
            energies,
            ledger,
            vesicles,
            ..*self.report
        };
        match Arc::get_mut(&mut picture.state) {
            Some(state) => state.clone_from(self.state),
            None => picture.state = Arc::new(self.state.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::RunId;
    use super::*;

    fn state(value: f64) -> State {
        State {
            phi: vec![value; 9],
            omega: vec![-value; 9],
            mu: vec![2.0 * value; 9],
            director: Some([vec![value; 9], vec![3.0 * value; 9]]),
        }
    }

    fn paint(canvases: &mut SnapshotPool, step: u64) -> Arc<RunSnapshot> {
        let report = Report {
            step,
            ..Report::default()
        };
        canvases.paint(SnapshotOf {
            run: RunId(1),
            anchoring: None,
            report: &report,
            mesh: &Arc::new(Mesh::structured(2, 0.0, 0).expect("a regular mesh")),
            state: &state(step as f64),
        })
    }

    #[test]
    fn the_latest_wins_and_is_fetched_once() {
        let (mailbox, mut canvases) = (Mailbox::default(), SnapshotPool::default());
        assert!(mailbox.fetch().is_none());
        mailbox.put(paint(&mut canvases, 1));
        mailbox.put(paint(&mut canvases, 2));
        assert!(!mailbox.is_empty());
        assert_eq!(mailbox.fetch().map(|picture| picture.report.step), Some(2));
        assert!(mailbox.is_empty() && mailbox.fetch().is_none());
    }

    #[test]
    fn three_canvases_serve_for_ever() {
        let (mailbox, mut canvases) = (Mailbox::default(), SnapshotPool::default());
        let mut shown = None;
        let mut places = Vec::new();
        for step in 0..100 {
            mailbox.put(paint(&mut canvases, step));
            if step % 3 == 0 {
                shown = mailbox.fetch();
            }
            let picture = shown.as_ref().expect("fetched at step 0");
            assert_eq!(picture.report.step, step - step % 3);
            assert_eq!(*picture.state, state(picture.report.step as f64));
            let director = picture.state.director.as_ref().expect("a director");
            places.push((Arc::as_ptr(picture), director[1].as_ptr()));
        }
        places.sort_unstable();
        places.dedup();
        assert!(places.len() <= CANVASES, "{places:?}");
    }

    #[test]
    fn a_picture_that_is_kept_is_never_painted_over() {
        let mut canvases = SnapshotPool::default();
        let kept: Vec<_> = (0..20).map(|step| paint(&mut canvases, step)).collect();
        for (step, picture) in kept.iter().enumerate() {
            assert_eq!(*picture.state, state(step as f64));
        }
        assert_eq!(canvases.0.len(), CANVASES);
    }
}
