//! Work that is counted in tests of this crate. Elsewhere the calls are empty, and cost nothing.

/// What a thread has done.
#[cfg(test)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Counts {
    /// Products of a sparse matrix and a vector.
    pub(crate) products: u64,
    /// Matrices assembled.
    pub(crate) assemblies: u64,
}

#[cfg(test)]
thread_local! {
    static COUNTS: std::cell::Cell<Counts> = std::cell::Cell::default();
}

/// So many products of a sparse matrix and a vector.
#[inline(always)]
pub(crate) fn products(_count: u64) {
    #[cfg(test)]
    COUNTS.with(|counts| {
        let mut now = counts.get();
        now.products += _count;
        counts.set(now);
    });
}

/// So many matrices assembled.
#[inline(always)]
pub(crate) fn assemblies(_count: u64) {
    #[cfg(test)]
    COUNTS.with(|counts| {
        let mut now = counts.get();
        now.assemblies += _count;
        counts.set(now);
    });
}

/// What `work` did.
#[cfg(test)]
pub(crate) fn of(work: impl FnOnce()) -> Counts {
    let before = COUNTS.with(std::cell::Cell::get);
    work();
    let after = COUNTS.with(std::cell::Cell::get);
    Counts {
        products: after.products - before.products,
        assemblies: after.assemblies - before.assemblies,
    }
}
