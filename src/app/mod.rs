//! The window: the editor of [`crate::ui`], values derived from its scene, and its files.
//!
//! `ui` edits an [`Editor`](crate::ui::Editor), reads a [`Shown`](crate::ui::Shown) and returns [`Command`](crate::ui::Command)s; [`Window`] owns all three.
//! [`Window::frame`] draws the panels, applies pointer input to the scene, updates derived values in the
//! `Workshop`, and paints the canvas; after a change one more frame follows for the panels' figures. Without
//! changes, nothing is drawn.
//!
//! An undo step is recorded when no button is held and no text is being typed: a drag, a stroke or a typed word is
//! one step. A scene that cannot be solved stays as edited, with the reason on the canvas and the last picture
//! behind it. After a lost device, the editor with its history moves to a second window drawn by OpenGL
//! (`desktop`).
//!
//! The feature `window` includes eframe, egui, egui_plot, rfd and usvg; without it `sonoglyph` writes the sheet, as
//! it does without a display. In a browser some files are replaced by others: `src/web/mod.rs` lists them.

mod board_tests;
#[cfg(target_arch = "wasm32")]
mod browser;
mod comparison;
#[cfg(not(target_arch = "wasm32"))]
mod desktop;
mod errand;
mod examples;
mod figure;
mod files;
mod folders;
mod job;
mod link;
mod mapping;
mod measured_figures;
mod measuring;
#[cfg(target_arch = "wasm32")]
pub mod page;
mod posing;
mod preparing;
mod printing;
pub mod recovery;
#[cfg_attr(target_arch = "wasm32", path = "no_screen.rs")]
mod screen;
#[cfg_attr(target_arch = "wasm32", path = "no_serving.rs")]
mod serving;
pub mod settings;
mod slow;
mod space;
mod thumbnails;
mod window;
#[cfg(target_arch = "wasm32")]
mod worker;
mod workshop;

#[cfg(not(target_arch = "wasm32"))]
pub use desktop::run;
pub use window::Window;
