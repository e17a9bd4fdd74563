//! What the library shows to the JavaScript of a page.

pub mod field;
#[cfg(feature = "serial")]
pub mod link;
