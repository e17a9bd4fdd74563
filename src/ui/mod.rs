//! The window's panels, canvas and tools. They edit an [`Editor`], show a [`Shown`] and return [`Command`]s; files, threads,
//! solving and the field are elsewhere.

pub mod action;
mod arrangement;
mod array;
pub mod arrows;
pub mod beside;
pub mod board;
pub mod bring_up;
pub mod brush;
pub mod canvas;
mod clipboard;
mod command;
pub mod compare;
mod context;
mod cursor;
mod dialog;
mod dimensions;
pub mod document;
mod edit;
mod editor;
mod element_map;
mod expression;
mod frame;
pub mod gallery;
mod gesture;
mod group;
mod guides;
mod handle;
mod icon;
pub mod keys;
pub mod legend;
mod looking;
mod map;
mod marks;
pub mod measure;
mod menu;
pub mod number;
mod palm;
mod panels;
mod path_marks;
pub mod section;
mod segments;
mod shown;
pub mod space;
mod status;
pub mod theme;
mod ticks;
mod timeline;
pub mod tool;
mod transform;
mod typing;
pub mod view;
mod view_bar;
mod way;

pub use arrangement::Layout;
pub use command::{Command, Export};
pub use dialog::Dialog;
pub use dialog::figure::{FigureForm, Preview};
pub use dialog::file::{Asking, ELEMENTS, Entry, Folder, IMPORTED, Purpose};
pub use dialog::film::FilmForm;
pub use dialog::import::Import;
pub use editor::{BeadForm, BeadPlace, CourseForm, CoursePlace, Editor, Oscillation, Panel, Playback};
pub use frame::show;
pub use map::{Map, Texture};
pub use panels::{bead, course};
pub use shown::{
    Arrows, Course, Extremes, Levitated, MethodRow, Notice, Pressed, ServingShown, Shown, Sound,
};

/// Whether the window is a page of a browser.
pub const IN_PAGE: bool = cfg!(target_arch = "wasm32");
