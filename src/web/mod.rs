//! The library in a browser: its interface to JavaScript, and the places where a page differs from a desktop.
//!
//! The page is the window's code compiled for `wasm32-unknown-unknown`, with the feature `window` and without
//! `cli`; `web/build` makes it a folder of static files. Where a browser differs, one file replaces another
//! (`#[path]`), invisibly to higher layers:
//!
//! | desktop | page |
//! |---|---|
//! | `app::desktop`: a winit window, drawn by wgpu or OpenGL | `app::page`: a canvas, drawn by WebGL 2 (`no_screen`) |
//! | files on disk (`source`, `output::disk`) | `shelf`: in memory; written files are downloads; small files and persistent data are in local storage, with a recovery file per open page |
//! | a thread (`studio::later`) | after the frame; solving (`app::job`) in a web worker that receives scenes and returns drives as bytes (`app::worker`, `web/worker.js`) |
//! | AVX and NEON, selected at run time (`simd`) | SIMD128, selected at build time |
//! | a GPU that draws the window, with blocking reads for files | WebGPU: requested before the first frame (`gpu::adapter::open`), its values awaited between frames (`app::mapping`) and coloured by the CPU; software GPUs are slower than SIMD128 and used with `?gpu=any` only |
//! | a scene link `sonoglyph:#…` | the page's address with the same text; a changed address opens its scene |
//! | ffmpeg | not available: GIF and animated PNG only |
//! | sockets for other programs (`control`, `app::serving`) | not available (`no_serving`) |
//! | serial ports (`port::system`), a thread per link (`task::thread`) | Web Serial (`port::page`), a task between frames (`task::page`) |
//!
//! A page cannot block on the GPU: `Gpu::wait` refuses. `Stages::poll` makes a map without waiting on any platform,
//! and keeps the previous map until the new one is ready.
//!
//! Pages are built for SIMD128, so plain loops are vector code without a second copy. Function calls in loops are
//! expensive: `f32::max` is a call (`simd::larger` is not), as are `mul_add` and all mathematical library
//! functions. rustfft has its own vector code behind a feature.
//!
//! `web/tools` is a separate crate: it generates the JavaScript bindings (as wasm-bindgen's own command does),
//! packs and serves. `web/tests/field.html` uses [`field`] without the window; `field.py` compares its values with
//! the command line's in Chromium and Firefox, by SIMD128 and by WebGPU. `page.py` operates the page in headless
//! Chromium by pointer and keys, reading its state from `sonoglyph.shown()`. `serial.py` compares the bytes written
//! by a page to a port (`stand-in.js`) with those of `sonoglyph send`.

pub mod field;
pub mod link;
