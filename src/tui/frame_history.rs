//! Older fields of a run within a budget of memory, evenly thinned.

use std::sync::Arc;

use crate::fem::extent_of_inside;
use crate::geometry::BoundingBox;
use crate::simulation::RunSnapshot;

/// Bytes that older fields may take, by default.
pub const BUDGET: usize = 64 << 20;

/// What they may take of the memory that is free and that they have already: a third, and no more than
/// [`BUDGET`].
pub fn budget(free: u64, stored: usize) -> usize {
    let free = usize::try_from(free).unwrap_or(usize::MAX);
    BUDGET.min(free.saturating_add(stored) / 3)
}

/// The stored pictures of a run, in order of their steps.
///
/// The steps are divided into intervals of the same width, and of each interval the first picture
/// that came is kept; the newest of all is kept in any case. When the budget is spent the width is
/// doubled, so that what is kept lies evenly over the whole past.
#[derive(Debug)]
pub struct FrameHistory {
    pictures: Vec<Arc<RunSnapshot>>,
    bytes: usize,
    budget: usize,
    /// Steps of an interval: a power of two.
    width: u64,
    /// The step of a picture that must not be thinned out: it is shown.
    pinned: Option<u64>,
    /// The rectangle around the vesicle in all pictures that came.
    vesicle: Option<BoundingBox>,
}

impl Default for FrameHistory {
    fn default() -> Self {
        Self::new(BUDGET)
    }
}

impl FrameHistory {
    /// An empty history that will take at most `budget` bytes, or two pictures where they need more.
    pub fn new(budget: usize) -> Self {
        Self {
            pictures: Vec::new(),
            bytes: 0,
            budget,
            width: 1,
            pinned: None,
            vesicle: None,
        }
    }

    /// The rectangle around the vesicle in all pictures that came, also in those that are not stored any more.
    pub fn vesicle(&self) -> Option<BoundingBox> {
        self.vesicle
    }

    /// How many are stored.
    pub fn len(&self) -> usize {
        self.pictures.len()
    }

    /// Whether none is stored.
    pub fn is_empty(&self) -> bool {
        self.pictures.is_empty()
    }

    /// The picture of an index, the oldest first.
    pub fn get(&self, index: usize) -> Option<&Arc<RunSnapshot>> {
        self.pictures.get(index)
    }

    /// The picture whose time is nearest to this.
    pub fn nearest(&self, t: f64) -> Option<&Arc<RunSnapshot>> {
        let after = self.pictures.partition_point(|it| it.report.t < t);
        let around = &self.pictures[after.saturating_sub(1)..self.pictures.len().min(after + 1)];
        let distance = |picture: &Arc<RunSnapshot>| (picture.report.t - t).abs();
        (around.iter()).min_by(|one, other| distance(one).total_cmp(&distance(other)))
    }

    /// The index of the first picture at this time or later; that of the newest where there is none.
    pub fn first_from(&self, t: f64) -> usize {
        let index = self.pictures.partition_point(|it| it.report.t < t);
        index.min(self.pictures.len().saturating_sub(1))
    }

    /// The index of the picture of a step, if it is stored.
    pub fn position(&self, step: u64) -> Option<usize> {
        self.pictures
            .binary_search_by_key(&step, |picture| picture.report.step)
            .ok()
    }

    /// The index of the picture that is pinned, if it is stored.
    pub fn pinned_position(&self) -> Option<usize> {
        self.position(self.pinned?)
    }

    /// Bytes of all that is stored.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Keeps the picture of this step from being thinned out; the one that was pinned before is no
    /// longer pinned.
    pub fn pin(&mut self, step: Option<u64>) {
        self.pinned = step;
    }

    /// Stores the newest picture. One of the same step as the last takes its place (the anchoring
    /// was switched); one of an earlier step is refused.
    pub fn put(&mut self, picture: Arc<RunSnapshot>) {
        let step = picture.report.step;
        if let Some(last) = self.pictures.last() {
            let last_step = last.report.step;
            if step < last_step {
                return;
            }
            if step == last_step || !self.is_kept(self.pictures.len() - 1) {
                self.bytes -= self.bytes_of(self.pictures.len() - 1);
                self.pictures.pop();
            }
        }
        if let Some(now) = extent_of_inside(&picture.mesh, &picture.state.phi) {
            self.vesicle = Some(self.vesicle.map_or(now, |before| before.union(&now)));
        }
        self.pictures.push(picture);
        self.bytes += self.bytes_of(self.pictures.len() - 1);
        self.fit();
    }

    /// Takes at most `budget` bytes from now on: other runs have started or ended.
    pub fn set_budget(&mut self, budget: usize) {
        self.budget = budget;
        self.fit();
    }

    /// Thins out until the budget is kept, if there is anything to thin out.
    fn fit(&mut self) {
        let newest = (self.pictures.last()).map_or(0, |picture| picture.report.step);
        while self.bytes > self.budget && self.pictures.len() > 2 && self.width <= newest {
            self.thin();
        }
    }

    /// Whether a picture is kept even when it is not the newest: it is the first of its interval,
    /// or pinned.
    fn is_kept(&self, index: usize) -> bool {
        let step = self.pictures[index].report.step;
        let first =
            index == 0 || self.pictures[index - 1].report.step / self.width < step / self.width;
        first || self.pinned == Some(step)
    }

    /// Doubles the width.
    fn thin(&mut self) {
        self.width *= 2;
        let last = self.pictures.len() - 1;
        let mut interval = None;
        let mut index = 0;
        let (width, pinned) = (self.width, self.pinned);
        self.pictures.retain(|picture| {
            let step = picture.report.step;
            let first = interval != Some(step / width);
            interval = Some(step / width);
            let kept = first || index == last || pinned == Some(step);
            index += 1;
            kept
        });
        self.bytes = (0..self.pictures.len())
            .map(|index| self.bytes_of(index))
            .sum();
    }

    /// The memory of a picture, with that of its mesh where the one before has another.
    fn bytes_of(&self, index: usize) -> usize {
        let picture = &self.pictures[index];
        let before = index.checked_sub(1).map(|before| &self.pictures[before]);
        let shares = before.is_none_or(|before| Arc::ptr_eq(&before.mesh, &picture.mesh));
        bytes_of(picture) + if shares { 0 } else { picture.mesh.bytes() }
    }
}

/// The memory of a picture without its mesh.
fn bytes_of(picture: &RunSnapshot) -> usize {
    let state = &picture.state;
    let director = state
        .director
        .as_ref()
        .map_or(0, |[x, y]| x.len() + y.len());
    let values = state.phi.len() + state.omega.len() + state.mu.len() + director;
    let named = picture.report.energies.len() + picture.report.ledger.len();
    size_of::<RunSnapshot>()
        + values * size_of::<f64>()
        + named * size_of::<crate::physics::NamedValue>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Mesh;
    use crate::scheme::State;
    use std::sync::LazyLock;

    use crate::simulation::{Report, RunId};

    fn picture(step: u64) -> Arc<RunSnapshot> {
        static MESH: LazyLock<Arc<Mesh>> = LazyLock::new(|| mesh(9));
        picture_on(&MESH, step)
    }

    fn mesh(cells: usize) -> Arc<Mesh> {
        Arc::new(Mesh::structured(cells, 0.0, 0).expect("a regular mesh"))
    }

    fn picture_on(mesh: &Arc<Mesh>, step: u64) -> Arc<RunSnapshot> {
        let field = vec![step as f64; 100];
        Arc::new(RunSnapshot {
            run: RunId(1),
            anchoring: None,
            report: Report {
                step,
                ..Report::default()
            },
            mesh: mesh.clone(),
            state: Arc::new(State {
                phi: field.clone(),
                omega: field.clone(),
                mu: field,
                director: None,
            }),
        })
    }

    fn steps(past: &FrameHistory) -> Vec<u64> {
        past.pictures
            .iter()
            .map(|picture| picture.report.step)
            .collect()
    }

    #[test]
    fn everything_is_kept_while_there_is_room() {
        let mut past = FrameHistory::default();
        for step in 0..50 {
            past.put(picture(3 * step));
        }
        assert_eq!(steps(&past), (0..50).map(|n| 3 * n).collect::<Vec<_>>());
        assert_eq!(past.position(33), Some(11));
        assert_eq!(past.position(34), None);
        assert_eq!(past.bytes(), 50 * bytes_of(&picture(0)));
    }

    #[test]
    fn what_is_kept_lies_evenly_and_within_the_budget() {
        let room = 100;
        let mut past = FrameHistory::new(room * bytes_of(&picture(0)));
        let mut step = 0;
        for n in 0_u64..20_000 {
            past.put(picture(step));
            assert!(past.bytes() <= past.budget);
            let kept = steps(&past);
            assert_eq!((kept[0], kept[kept.len() - 1]), (0, step));
            if n > room as u64 {
                assert!(kept.len() >= room / 2 - 1, "{} at step {step}", kept.len());
            }
            // Pictures come every 1 to 7 steps; the newest may be near the one before.
            let early = past.width.saturating_sub(7).max(1);
            let gaps = kept.windows(2).map(|pair| pair[1] - pair[0]);
            for gap in gaps.rev().skip(1) {
                assert!(
                    gap >= early && gap < past.width + 7 + 1,
                    "{gap} of {}",
                    past.width
                );
            }
            step += 1 + n * n % 7;
        }
        assert!(past.width > 100);
    }

    #[test]
    fn the_picture_that_is_looked_at_stays() {
        let mut past = FrameHistory::new(10 * bytes_of(&picture(0)));
        for step in 0..10 {
            past.put(picture(step));
        }
        past.pin(Some(7));
        for step in 10..10_000 {
            past.put(picture(step));
            assert!(past.position(7).is_some());
            assert!(past.bytes() <= past.budget);
        }
        past.pin(None);
        for step in 10_000..40_000 {
            past.put(picture(step));
        }
        assert_eq!(past.position(7), None);
    }

    #[test]
    fn a_smaller_budget_is_kept_at_once() {
        let mut past = FrameHistory::default();
        for step in 0..100 {
            past.put(picture(step));
        }
        past.set_budget(20 * bytes_of(&picture(0)));
        let kept = steps(&past);
        assert!(past.bytes() <= past.budget && kept.len() >= 10, "{kept:?}");
        assert_eq!((kept[0], kept[kept.len() - 1]), (0, 99));
        past.set_budget(BUDGET);
        assert_eq!(steps(&past), kept);
    }

    #[test]
    fn a_part_of_what_is_free_is_taken() {
        assert_eq!(budget(u64::MAX, BUDGET), BUDGET);
        assert_eq!(budget(30 << 20, 0), 10 << 20);
        // Once it is taken it is not free any more, and the part is the same.
        assert_eq!(budget(20 << 20, 10 << 20), 10 << 20);
    }

    /// Each mesh counts once, but for the first, which the run has in any case.
    #[test]
    fn meshes_count_where_they_change() {
        let mut past = FrameHistory::new(usize::MAX);
        let (one, other) = (mesh(9), mesh(9));
        for (step, mesh) in [&one, &one, &other, &other, &one].into_iter().enumerate() {
            past.put(picture_on(mesh, step as u64));
        }
        let states = 5 * bytes_of(&picture(0));
        assert_eq!(past.bytes(), states + 2 * one.bytes());
        past.set_budget(states + one.bytes());
        assert!(past.len() < 5 && past.bytes() <= past.budget);
        let meshes: Vec<bool> = past
            .pictures
            .iter()
            .map(|it| Arc::ptr_eq(&it.mesh, &one))
            .collect();
        assert_eq!((meshes[0], meshes[meshes.len() - 1]), (true, true));
    }

    #[test]
    fn the_vesicle_is_known_wherever_it_was() {
        let mut past = FrameHistory::new(1);
        // φ is 0 in this picture, and there is no vesicle.
        past.put(picture(0));
        assert_eq!(past.vesicle(), None);
        let part = |is_inside: fn(f64) -> bool| {
            let mut picture = Arc::unwrap_or_clone(picture(1));
            let state = Arc::make_mut(&mut picture.state);
            for (phi, node) in state.phi.iter_mut().zip(picture.mesh.nodes()) {
                *phi = if is_inside(node.x) { 1.0 } else { -1.0 };
            }
            Arc::new(picture)
        };
        past.put(part(|x| x < 0.3));
        past.put(part(|x| (0.5..0.6).contains(&x)));
        let vesicle = past.vesicle().expect("there is one");
        let sides = [vesicle.lower.x, vesicle.upper.x].map(|x| (9.0 * x).round());
        assert_eq!(sides, [0.0, 5.0]);
    }

    #[test]
    fn the_same_step_again_takes_the_place_and_an_earlier_one_is_refused() {
        let mut past = FrameHistory::default();
        past.put(picture(0));
        past.put(picture(5));
        let again = picture(5);
        past.put(again.clone());
        past.put(picture(4));
        assert_eq!(steps(&past), [0, 5]);
        assert!(past.get(1).is_some_and(|last| Arc::ptr_eq(last, &again)));
    }

    #[test]
    fn pictures_larger_than_the_budget_leave_the_first_and_the_last() {
        let mut past = FrameHistory::new(1);
        for step in 0..100 {
            past.put(picture(step));
            assert!(past.len() <= 2);
        }
        assert_eq!(steps(&past), [0, 99]);
    }
}
