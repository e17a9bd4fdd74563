//! The library's interface to JavaScript.

pub mod field;
pub mod link;
