//! Work that falls into pieces: in the threads of the pool that the caller runs in, or one piece after the other where
//! it runs in none. How the work is divided does not change a result: every number is computed by one piece, in the
//! same order of operations, and whoever adds up what pieces have found does so in the order of the pieces.

/// Shorter slices are not divided: to hand a piece over takes a few microseconds, as long as a product with a few
/// hundred rows.
const SHORTEST: usize = 1024;

/// The lengths of pieces are multiples of this: a block of rows of a matrix, one cache line of f64.
const UNIT: usize = 8;

/// Pieces a thread: more than one, for threads are not equally fast.
const PIECES: usize = 2;

/// Whether the caller runs in a pool of several threads.
pub fn is_shared() -> bool {
    rayon::current_thread_index().is_some() && rayon::current_num_threads() > 1
}

/// Slices that are cut at the same place.
pub trait Divide: Send + Sized {
    /// What lies before this place and what lies behind it; all before it where a slice is shorter.
    fn divide_at(self, place: usize) -> (Self, Self);
}

impl Divide for () {
    fn divide_at(self, _: usize) -> (Self, Self) {
        ((), ())
    }
}

impl<E: Send, const N: usize> Divide for [&mut [E]; N] {
    fn divide_at(self, place: usize) -> (Self, Self) {
        let mut far: Self = std::array::from_fn(|_| Default::default());
        let mut rest = far.iter_mut();
        let near = self.map(|slice| {
            let (near, behind) = slice.split_at_mut(place.min(slice.len()));
            if let Some(far) = rest.next() {
                *far = behind;
            }
            near
        });
        (near, far)
    }
}

impl<A: Divide, B: Divide> Divide for (A, B) {
    fn divide_at(self, place: usize) -> (Self, Self) {
        let (a, other_a) = self.0.divide_at(place);
        let (b, other_b) = self.1.divide_at(place);
        ((a, b), (other_a, other_b))
    }
}

/// Calls f(first, pieces) for pieces of slices of the same length, where `first` is the number of their first entry.
/// Pieces begin at multiples of eight.
pub fn over_pieces<const N: usize>(
    slices: [&mut [f64]; N],
    f: impl Fn(usize, [&mut [f64]; N]) + Sync,
) {
    let length = length_of(&slices);
    if length < 2 * SHORTEST || !is_shared() {
        return f(0, slices);
    }
    let pieces = PIECES * rayon::current_num_threads();
    let most = length.div_ceil(pieces).next_multiple_of(UNIT);
    pieces_of(0, slices, most.max(SHORTEST), &f);
}

fn length_of<const N: usize>(slices: &[&mut [f64]; N]) -> usize {
    slices.first().map_or(0, |slice| slice.len())
}

/// Calls f for pieces of at most the length `most`.
fn pieces_of<const N: usize>(
    first: usize,
    slices: [&mut [f64]; N],
    most: usize,
    f: &(impl Fn(usize, [&mut [f64]; N]) + Sync),
) {
    let length = length_of(&slices);
    if length <= most {
        return f(first, slices);
    }
    let middle = (length / 2).next_multiple_of(UNIT);
    let (near, far) = slices.divide_at(middle);
    rayon::join(
        || pieces_of(first, near, most, f),
        || pieces_of(first + middle, far, most, f),
    );
}

/// Calls f(number, item, parts) for every item with its part of the slices: `entries` entries of each, fewer for the last.
pub fn over_items<T: Send, D: Divide>(
    items: &mut [T],
    (slices, entries): (D, usize),
    f: impl Fn(usize, &mut T, D) + Sync,
) {
    items_of(0, items, (slices, entries), is_shared(), &f);
}

fn items_of<T: Send, D: Divide>(
    first: usize,
    items: &mut [T],
    (slices, entries): (D, usize),
    is_shared: bool,
    f: &(impl Fn(usize, &mut T, D) + Sync),
) {
    match items {
        [] => {}
        [item] => f(first, item, slices),
        items => {
            let middle = items.len() / 2;
            let (near, far) = items.split_at_mut(middle);
            let (before, behind) = slices.divide_at(middle * entries);
            let near = || items_of(first, near, (before, entries), is_shared, f);
            let far = || items_of(first + middle, far, (behind, entries), is_shared, f);
            if is_shared {
                rayon::join(near, far);
            } else {
                near();
                far();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pool, in which `work` is done.
    fn with_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("a few threads").install(work)
    }

    #[test]
    fn every_entry_is_in_one_piece_whatever_the_number_of_threads() {
        for length in [0, 5, 2047, 2048, 10_001] {
            let fill = || {
                let (mut a, mut b) = (vec![0.0; length], vec![0.0; length]);
                over_pieces([&mut a, &mut b], |first, [a, b]| {
                    assert!(first % UNIT == 0 && a.len() == b.len());
                    for (index, (a, b)) in a.iter_mut().zip(b).enumerate() {
                        *a += (first + index) as f64;
                        *b -= (first + index) as f64;
                    }
                });
                let (mut items, entries) = (vec![0; 20], length.div_ceil(20));
                over_items(
                    &mut items,
                    ([&mut a[..]], entries),
                    |number, item, [part]| {
                        *item += number + part.len();
                    },
                );
                (a, b, items)
            };
            let alone = fill();
            assert!(
                alone
                    .0
                    .iter()
                    .enumerate()
                    .all(|(index, a)| *a == index as f64)
            );
            assert!(alone.0.iter().zip(&alone.1).all(|(a, b)| a + b == 0.0));
            for threads in [1, 2, 3] {
                assert_eq!(with_threads(threads, fill), alone);
            }
        }
        assert!(!is_shared() && !with_threads(1, is_shared) && with_threads(2, is_shared));
    }
}
