//! Older fields of a run within a budget of memory, evenly thinned.

use std::sync::Arc;

use crate::simulation::Picture;

/// The stored pictures of a run, in order of their steps.
#[derive(Debug, Default)]
pub struct Past {
    pictures: Vec<Arc<Picture>>,
}

impl Past {
    /// How many are stored.
    pub fn len(&self) -> usize {
        self.pictures.len()
    }

    /// Whether none is stored.
    pub fn is_empty(&self) -> bool {
        self.pictures.is_empty()
    }

    /// The picture of an index, the oldest first.
    pub fn get(&self, index: usize) -> Option<&Arc<Picture>> {
        self.pictures.get(index)
    }
}
