//! Serial ports of a browser page (Web Serial), through `page.js`.
//!
//! A port's name is its USB numbers, and a bit rate is changed by closing and opening. Each open line deposits the
//! bytes of its silence in `page.js`, which are sent when the page is left (`pagehide`) or its program traps and no
//! Rust code runs any more.

use std::io;
use std::path::{Path, PathBuf};

use js_sys::{Array, Promise, Reflect, Uint8Array};
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsCast, JsValue};
use wasm_bindgen_futures::JsFuture;
use web_time::Duration;

use crate::device::port::error::{Listed, PortError, WRITE_TIMEOUT};
use crate::device::task::within;

#[wasm_bindgen(module = "/src/device/port/page.js")]
extern "C" {
    /// Whether this browser has serial ports for pages.
    pub fn is_there() -> bool;

    #[wasm_bindgen(js_name = available)]
    fn names() -> Promise;

    #[wasm_bindgen(js_name = choose)]
    fn choose_by_name() -> Promise;

    #[wasm_bindgen(js_name = open)]
    fn open_by_name(name: &str, baud: u32) -> Promise;

    #[derive(Debug)]
    type Line;

    #[wasm_bindgen(method)]
    fn write(this: &Line, bytes: &[u8]) -> Promise;

    #[wasm_bindgen(method)]
    fn arrives(this: &Line) -> Promise;

    #[wasm_bindgen(method, catch)]
    fn take(this: &Line) -> Result<Uint8Array, JsValue>;

    #[wasm_bindgen(method)]
    fn set_baud(this: &Line, baud: u32) -> Promise;

    #[wasm_bindgen(method)]
    fn leave(this: &Line, bytes: &[u8]) -> bool;

    #[wasm_bindgen(method)]
    fn leave_behind(this: &Line, bytes: &[u8]);

    #[wasm_bindgen(method)]
    fn end(this: &Line);
}

/// The ports permitted to this page, sorted.
///
/// # Errors
/// A browser without an answer.
pub async fn available() -> io::Result<Vec<Listed>> {
    let names = JsFuture::from(names()).await.map_err(|error| io_error(&error))?;
    let listed = |name: JsValue| {
        let path = PathBuf::from(name.as_string()?);
        Some(Listed { path, what: None, profile: None })
    };
    Ok(Array::from(&names).iter().filter_map(listed).collect())
}

/// Lets the user choose a port for this page, which requires a preceding click. `None` without a choice.
///
/// # Errors
/// A browser that denies ports.
pub async fn choose() -> io::Result<Option<PathBuf>> {
    let name = JsFuture::from(choose_by_name()).await.map_err(|error| io_error(&error))?;
    Ok(name.as_string().map(PathBuf::from))
}

/// An open port.
#[derive(Debug)]
pub struct Wire {
    line: Line,
    name: String,
}

impl Wire {
    pub async fn open(path: &Path, baud: u32) -> Result<Self, PortError> {
        let name = path.display().to_string();
        if !is_there() {
            return Err(PortError::Missing(name));
        }
        match JsFuture::from(open_by_name(&name, baud)).await {
            Ok(line) if line.is_null() => Err(PortError::Missing(name)),
            Ok(line) => Ok(Self { line: line.unchecked_into(), name }),
            Err(error) => Err(refused(name, baud, &error)),
        }
    }

    pub async fn set_baud(&mut self, baud: u32) -> Result<(), PortError> {
        let set = JsFuture::from(self.line.set_baud(baud)).await;
        set.map(drop).map_err(|error| refused(self.name.clone(), baud, &error))
    }

    pub async fn write(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        match within(WRITE_TIMEOUT, JsFuture::from(self.line.write(bytes))).await {
            Some(Ok(_)) => Ok(()),
            Some(Err(error)) => Err(self.lost(&error)),
            None => Err(PortError::Stalled(self.name.clone())),
        }
    }

    pub async fn read(&mut self, timeout: Duration) -> Result<Vec<u8>, PortError> {
        let here = self.take()?;
        if !here.is_empty() || timeout.is_zero() {
            return Ok(here);
        }
        within(timeout, JsFuture::from(self.line.arrives())).await;
        self.take()
    }

    fn take(&self) -> Result<Vec<u8>, PortError> {
        self.line.take().map(|bytes| bytes.to_vec()).map_err(|error| self.lost(&error))
    }

    /// Not possible without closing the port.
    #[expect(clippy::unused_self, reason = "a computer's ports")]
    pub fn discard(&mut self) -> bool {
        false
    }

    /// Unknown.
    #[expect(clippy::unused_self, reason = "a computer's ports")]
    pub fn held(&self) -> usize {
        0
    }

    pub fn leave(&mut self, last: &[u8]) -> bool {
        self.line.leave(last)
    }

    /// A page that is left cannot wait.
    pub fn leave_behind(&mut self, last: &[u8], _: Duration) -> io::Result<()> {
        self.line.leave_behind(last);
        Ok(())
    }

    fn lost(&self, error: &JsValue) -> PortError {
        PortError::Lost { path: self.name.clone(), error: io_error(error) }
    }
}

impl Drop for Wire {
    fn drop(&mut self) {
        self.line.end();
    }
}

/// The reason of a failure to open a port. Browsers report few distinct reasons.
fn refused(path: String, baud: u32, error: &JsValue) -> PortError {
    match property(error, "name").as_deref() {
        Some("InvalidStateError") => PortError::Busy(path),
        Some("SecurityError") => PortError::NoPermission(path),
        Some("TypeError" | "RangeError" | "NotSupportedError") => {
            PortError::Baud { path, baud, error: io_error(error) }
        }
        Some(_) | None => PortError::Unopened { path, error: io_error(error) },
    }
}

/// The error in the browser's words.
fn io_error(error: &JsValue) -> io::Error {
    io::Error::other(property(error, "message").unwrap_or_else(|| format!("{error:?}")))
}

/// A text property of an error.
fn property(error: &JsValue, name: &str) -> Option<String> {
    Reflect::get(error, &name.into()).ok()?.as_string()
}
