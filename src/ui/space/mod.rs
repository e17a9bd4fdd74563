//! The 3D view: its camera, contents and results.

mod act;
mod bar;
mod handle;
mod paint;
pub(crate) mod view;

pub use act::interact;
pub use bar::{is_settled, places, show as bar};
pub use paint::paint;
pub use view::{Seen, SpaceShown, SpaceView, Stage};
