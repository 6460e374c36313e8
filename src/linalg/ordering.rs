//! The order in which a sparse factorisation eliminates its unknowns.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

use super::{LinalgError, Pattern};

/// The rows of a symmetric pattern in an order that leaves few entries in a factor: approximate minimum
/// degree (faer).
///
/// # Errors
/// `Factorisation` when the library cannot (out of memory, index overflow).
pub fn minimum_degree(pattern: &Pattern) -> Result<Vec<u32>, LinalgError> {
    let size = pattern.size();
    let failed = |reason: String| LinalgError::Factorisation { size, reason };
    let mut start = vec![0];
    let mut columns = Vec::with_capacity(pattern.entries());
    for row in 0..size {
        columns.extend(pattern.row(row).map(|(_, column)| column));
        start.push(columns.len() as u32);
    }
    let structure = SymbolicSparseColMatRef::new_checked(size, size, &start, None, &columns);
    let request = amd::order_maybe_unsorted_scratch::<u32>(size, columns.len());
    let mut memory =
        MemBuffer::try_new(request).map_err(|_| failed("not enough memory".to_owned()))?;
    let (mut order, mut inverse) = (vec![0; size], vec![0; size]);
    amd::order_maybe_unsorted(
        &mut order,
        &mut inverse,
        structure,
        amd::Control::default(),
        MemStack::new(&mut memory),
    )
    .map_err(|error| failed(error.to_string()))?;
    Ok(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_a_star_comes_last() {
        // Eliminated first it would couple all others.
        let rows = (0..9_u32).map(|row| {
            if row == 4 {
                (0..9).collect()
            } else {
                vec![row.min(4), row.max(4)]
            }
        });
        let pattern = Pattern::from_rows(rows.collect());
        let mut order = minimum_degree(&pattern).expect("a small pattern");
        // Of the last two, which are coupled to each other alone, either may be the last.
        assert!(order[7..].contains(&4), "{order:?}");
        order.sort_unstable();
        assert!(order.into_iter().eq(0..9));
    }
}
