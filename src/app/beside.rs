//! Background work of the window: on a thread, or in a browser without threads between two frames.

/// Begins with it.
///
/// # Errors
/// No thread can be started.
#[cfg(not(target_arch = "wasm32"))]
pub fn run(name: &str, work: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
    std::thread::Builder::new().name(name.to_owned()).spawn(work).map(drop)
}

/// Runs it once the frame is on the screen.
///
/// # Errors
/// A browser without a window.
#[cfg(target_arch = "wasm32")]
pub fn run(_: &str, work: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
    use wasm_bindgen::JsCast;
    use wasm_bindgen::closure::Closure;
    /// ms
    const FRAME: i32 = 20;
    let window = web_sys::window().ok_or(std::io::ErrorKind::Unsupported)?;
    let work = Closure::once_into_js(work);
    let asked = window.set_timeout_with_callback_and_timeout_and_arguments_0(work.unchecked_ref(), FRAME);
    asked.map(drop).map_err(|_| std::io::ErrorKind::Unsupported.into())
}
