//! A cached value together with its inputs.

use std::convert::Infallible;

/// A value and its inputs.
#[derive(Clone, Debug)]
pub(super) struct Kept<K, V> {
    pub(super) key: Option<K>,
    pub(super) value: V,
}

impl<K, V: Default> Default for Kept<K, V> {
    fn default() -> Self {
        Self { key: None, value: V::default() }
    }
}

impl<K: Clone + PartialEq, V> Kept<K, V> {
    pub(super) fn is_of(&self, key: &K) -> bool {
        self.key.as_ref() == Some(key)
    }

    /// The value for `key`, recomputed in place (reusing its memory) if its inputs differ.
    pub(super) fn update(&mut self, key: &K, remake: impl FnOnce(&mut V)) -> &V {
        let remake = |value: &mut V| {
            remake(value);
            Ok::<_, Infallible>(())
        };
        match self.try_update(key, remake) {
            Ok(value) => value,
        }
    }

    /// The same for fallible computations; after an error the value has no key.
    pub(super) fn try_update<E>(
        &mut self,
        key: &K,
        remake: impl FnOnce(&mut V) -> Result<(), E>,
    ) -> Result<&V, E> {
        if !self.is_of(key) {
            self.key = None;
            remake(&mut self.value)?;
            self.key = Some(key.clone());
        }
        Ok(&self.value)
    }
}
