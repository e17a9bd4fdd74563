//! Data loaded from files named in a scene: shared by all copies of the scene, and never written into its file.

use std::sync::Arc;

/// Shared data, once loaded.
#[derive(Debug)]
pub struct Loaded<T: ?Sized>(Option<Arc<T>>);

impl<T: ?Sized> Loaded<T> {
    pub fn new(value: impl Into<Arc<T>>) -> Self {
        Self(Some(value.into()))
    }

    pub fn get(&self) -> Option<&T> {
        self.0.as_deref()
    }
}

impl<T: ?Sized> Default for Loaded<T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<T: ?Sized> Clone for Loaded<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T: ?Sized + PartialEq> PartialEq for Loaded<T> {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (None, None) => true,
            // Scenes are compared in every frame, usually with identical shared data.
            (Some(own), Some(others)) => Arc::ptr_eq(own, others) || own == others,
            (Some(_), None) | (None, Some(_)) => false,
        }
    }
}
