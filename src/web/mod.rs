//! The library's interface to JavaScript.

pub mod field;
#[cfg(feature = "serial")]
pub mod link;
