//! The window as a browser page, drawn by WebGL.
//!
//! `src/web/mod.rs` lists what a page replaces.

use std::cell::RefCell;
use std::path::Path;

use wasm_bindgen::prelude::{JsValue, wasm_bindgen};
use web_sys::{HtmlCanvasElement, WebGlContextAttributes, window};

use crate::app::browser::{KEPT, fill_shelf, follow_address, fragment, keep};
use crate::app::examples::{example, linked};
use crate::app::recovery::Recovery;
use crate::app::settings::Memory;
use crate::app::window::Window;
use crate::field::Evaluator;
use crate::field::gpu::adapter;
use crate::scene::{Scene, file};
use crate::shelf;
use crate::ui::Notice;
use crate::ui::document::Document;
use crate::ui::view::Lens;

thread_local! {
    static RUNNER: RefCell<Option<eframe::WebRunner>> = const { RefCell::new(None) };
}

/// Opens the window on a canvas, with the scene of the address (`#…`) or an example. Simultaneous pages have
/// different numbers, from 1, for separate recovery files.
///
/// # Errors
/// A browser without WebGL 2.
#[wasm_bindgen]
pub async fn start(canvas: HtmlCanvasElement, number: u32) -> Result<(), JsValue> {
    console_error_panic_hook::set_once();
    fill_shelf();
    shelf::keep_by(Box::new(keep));
    let (document, word) = first();
    let state = Path::new(KEPT).join(number.to_string());
    let evaluator = evaluator().await;
    let make: eframe::AppCreator<'static> = Box::new(move |context| {
        let mut window = Window::new(&context.egui_ctx, document, evaluator);
        let (memory, settings, problem) = Memory::at(Path::new(KEPT));
        window.remember(Some(memory), &settings, problem, &context.egui_ctx);
        window.recover(Recovery::at(&state));
        if let Some(text) = word {
            window.shown.notice = Some(Notice { text, is_error: true });
        }
        follow_address(&context.egui_ctx);
        Ok(Box::new(window))
    });
    // The window's edges are smooth as drawn; the browser's own smoothing takes a third of a frame without a hardware GPU.
    // A canvas keeps its first context, so eframe gets this one.
    let unsmoothed = WebGlContextAttributes::new();
    unsmoothed.set_antialias(false);
    canvas.get_context_with_context_options("webgl2", &unsmoothed)?;
    let options = eframe::WebOptions { dithering: false, ..Default::default() };
    let runner = eframe::WebRunner::new();
    RUNNER.with_borrow_mut(|own| *own = Some(runner.clone()));
    runner.start(canvas, options, make).await
}

/// The state of the page as JSON: the scene as its file, the displayed map, and whether work is pending.
#[wasm_bindgen]
pub fn shown() -> Option<String> {
    let runner = RUNNER.with_borrow(Clone::clone)?;
    let window = runner.app_mut::<Window>()?;
    let (scene, shown) = (window.editor.scene(), &window.shown);
    let seen = shown.map.as_ref().map(|map| {
        let lens = Lens { rect: map.rect, window: map.window };
        let plane = window.editor.view.plane(scene, &lens);
        let rect = [map.rect.left(), map.rect.top(), map.rect.width(), map.rect.height()];
        (plane, rect, map)
    });
    let plane = seen.as_ref().map_or_else(|| scene.plane.clone(), |(plane, ..)| plane.clone());
    let scene = file::write(&Scene { plane, ..scene.clone() });
    let said = serde_json::json!({
        "scene": scene,
        "size": seen.as_ref().map(|(_, _, map)| [map.width, map.height]),
        "rect": seen.as_ref().map(|(_, rect, _)| rect),
        "quantity": seen.as_ref().map(|(_, _, map)| map.quantity.declaration().name),
        "largest": seen.as_ref().map(|(_, _, map)| map.largest),
        "how": seen.as_ref().map(|(_, _, map)| map.how.clone()),
        "evaluator": shown.evaluator,
        "problem": shown.problem,
        "busy": window.is_busy(),
        "mapping": shown.mapping,
        "solving": shown.solving,
    });
    Some(said.to_string())
}

/// The browser's hardware GPU, otherwise the CPU: software GPUs take ten times as long. `?gpu=any` in the address
/// allows software GPUs, `?gpu=none` disables GPUs.
async fn evaluator() -> Evaluator {
    let wish = window().and_then(|window| window.location().search().ok()).unwrap_or_default();
    let opened = match wish.as_str() {
        "?gpu=none" => return Evaluator::Cpu,
        wish => adapter::open(wish == "?gpu=any").await,
    };
    opened.map_or(Evaluator::Cpu, |gpu| Evaluator::Gpu(Box::new(gpu)))
}

/// The scene of the address, or the first example and the reason.
fn first() -> (Document, Option<String>) {
    let own = || example(0).unwrap_or_else(|_| Document::new(Scene::default(), "untitled"));
    match fragment().map(|link| linked(&link)) {
        Some(Ok(document)) => (document, None),
        Some(Err(error)) => (own(), Some(format!("The link cannot be opened: {error:#}"))),
        None => (own(), None),
    }
}
