//! Operations on a scene shared by command line and window: evaluators, maps, pictures at rest and in motion, figures
//! as text, and atomic files.

pub mod animate;
pub mod arrays;
pub mod bodies;
pub mod bring_up;
pub mod convention;
pub mod demodulation;
pub mod directivity;
pub mod elements;
pub mod evaluator;
pub mod felt;
pub mod figure;
pub mod findings;
pub mod flight;
pub mod frames;
pub mod json;
pub mod later;
pub mod levitation;
pub mod link;
pub mod liquid;
pub mod map;
pub mod measurement;
pub mod motion;
pub mod nonlinear;
pub mod opening;
pub mod output;
pub mod paintings;
pub mod pattern;
pub mod performance;
pub mod player;
pub mod posing;
pub mod presets;
pub mod primaries;
pub mod probe;
pub mod reach;
pub mod response;
pub mod routes;
pub mod scattered;
pub mod sheet;
pub mod solving;
pub mod space;
pub mod spread;
#[cfg(not(target_arch = "wasm32"))]
pub mod still;
pub mod stimulus;
pub mod surfaces;
pub mod swell;
pub mod thresholds;
pub mod trade;
pub mod vectors;
#[cfg_attr(target_arch = "wasm32", path = "no_video.rs")]
pub mod video;
#[cfg(not(target_arch = "wasm32"))]
pub mod view_3d;
#[cfg(not(target_arch = "wasm32"))]
pub mod volume;
pub mod waveform;
pub mod width;

/// The scene shown by default.
pub const EXAMPLE: &str = include_str!("../../assets/scenes/hit.toml");
