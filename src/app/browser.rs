//! The browser around a page: its address, its storage, uploads and downloads.

use std::cell::RefCell;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use futures_channel::oneshot;
use js_sys::{Array, Uint8Array};
use wasm_bindgen::JsCast;
use wasm_bindgen::prelude::{Closure, JsValue, wasm_bindgen};
use web_sys::{Blob, Event, HtmlAnchorElement, HtmlInputElement, Storage, Url, window};

use crate::shelf;
use crate::studio::link;

/// The folder of persistent data, never offered as a download.
pub const KEPT: &str = "/kept";
/// Prefix of names in the browser's storage.
const PREFIX: &str = "sonoglyph:";
/// Limit in bytes of a user's file kept across page loads in the storage, which has some 5 MB.
const SMALL: usize = 1 << 18;

static FRAMES: AtomicU32 = AtomicU32::new(0);

thread_local! {
    /// The link that the address has changed to.
    static NEW_LINK: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Frames drawn so far.
#[wasm_bindgen]
pub fn frames() -> u32 {
    FRAMES.load(Ordering::Relaxed)
}

pub fn count_frame() {
    FRAMES.fetch_add(1, Ordering::Relaxed);
}

/// The scene in the page's address, as a link.
pub fn fragment() -> Option<String> {
    let fragment = window()?.location().hash().ok()?;
    fragment.strip_prefix('#').filter(|letters| !letters.is_empty()).map(link::of_letters)
}

/// The page's address without the fragment.
pub fn address() -> Option<String> {
    let location = window()?.location();
    Some(format!("{}{}", location.origin().ok()?, location.pathname().ok()?))
}

/// Clicking a link in an open page only changes the address: the scene is then opened as if pasted.
pub fn follow_address(ctx: &egui::Context) {
    let ctx = ctx.clone();
    let hear = Closure::<dyn FnMut()>::new(move || {
        if let Some(link) = fragment() {
            NEW_LINK.replace(Some(link));
            ctx.request_repaint();
        }
    });
    if let Some(window) = window() {
        // Without it a link takes effect on reload.
        let _ = window.add_event_listener_with_callback("hashchange", hear.as_ref().unchecked_ref());
        hear.forget();
    }
}

/// The link that the address has changed to.
pub fn new_link() -> Option<String> {
    NEW_LINK.take()
}

fn storage() -> Option<Storage> {
    window()?.local_storage().ok()?
}

/// Copies the storage's files to the shelf.
pub fn fill_shelf() {
    let Some(storage) = storage() else { return };
    for index in 0..storage.length().unwrap_or(0) {
        let Some(key) = storage.key(index).ok().flatten() else { continue };
        let Some(path) = key.strip_prefix(PREFIX) else { continue };
        let text = storage.get_item(&key).ok().flatten();
        if let Some(bytes) = text.and_then(|text| STANDARD.decode(text).ok()) {
            shelf::lay(Path::new(path), bytes);
        }
    }
}

fn key(path: &Path) -> String {
    format!("{PREFIX}{}", path.display())
}

/// Stores or forgets a file, and offers a user's file as a download.
pub fn keep(path: &Path, bytes: Option<&[u8]>) -> io::Result<()> {
    let Some(bytes) = bytes else {
        let _ = storage().map(|storage| storage.remove_item(&key(path)));
        return Ok(());
    };
    if path.starts_with(KEPT) {
        let full = || io::Error::other("the browser's storage is full or switched off");
        let stored = storage().map(|storage| storage.set_item(&key(path), &STANDARD.encode(bytes)));
        return stored.and_then(Result::ok).ok_or_else(full);
    }
    remember(path, bytes);
    download(path, bytes).map_err(|_| io::Error::other("the browser refuses the file"))
}

/// Keeps a small file across page loads.
fn remember(path: &Path, bytes: &[u8]) {
    if bytes.len() <= SMALL {
        // A full storage only loses this file.
        let _ = storage().map(|storage| storage.set_item(&key(path), &STANDARD.encode(bytes)));
    }
}

/// Offers a file as a download.
fn download(path: &Path, bytes: &[u8]) -> Result<(), JsValue> {
    let document = window().and_then(|window| window.document()).ok_or(JsValue::NULL)?;
    let parts = Array::of1(&Uint8Array::from(bytes));
    let url = Url::create_object_url_with_blob(&Blob::new_with_u8_array_sequence(&parts)?)?;
    let anchor: HtmlAnchorElement = document.create_element("a")?.dyn_into()?;
    anchor.set_href(&url);
    anchor.set_download(&path.file_name().unwrap_or_default().to_string_lossy());
    anchor.click();
    // The browser reads the bytes later; they are released afterwards, or with the page.
    let forget = Closure::once_into_js(move || Url::revoke_object_url(&url));
    let window = window().ok_or(JsValue::NULL)?;
    window.set_timeout_with_callback_and_timeout_and_arguments_0(forget.unchecked_ref(), 60_000).map(drop)
}

/// Lays a file of the user's on the shelf.
pub fn take(name: &Path, bytes: Vec<u8>) -> PathBuf {
    let path = Path::new("/").join(name);
    remember(&path, &bytes);
    shelf::lay(&path, bytes);
    path
}

/// Opens the browser's file dialog; returns the file's path on the shelf. `None` without a choice.
pub async fn pick(extensions: &[&str]) -> Option<PathBuf> {
    let input: HtmlInputElement = window()?.document()?.create_element("input").ok()?.dyn_into().ok()?;
    input.set_type("file");
    let endings: Vec<_> = extensions.iter().map(|ending| format!(".{ending}")).collect();
    input.set_accept(&endings.join(","));
    let (sender, chosen) = oneshot::channel();
    let mut sender = Some(sender);
    let hear = Closure::<dyn FnMut(Event)>::new(move |_| {
        // There is no receiver after the first event.
        let _ = sender.take().map(|sender| sender.send(()));
    });
    for event in ["change", "cancel"] {
        input.add_event_listener_with_callback(event, hear.as_ref().unchecked_ref()).ok()?;
    }
    input.click();
    chosen.await.ok()?;
    let file = input.files()?.get(0)?;
    let bytes = wasm_bindgen_futures::JsFuture::from(file.array_buffer()).await.ok()?;
    Some(take(Path::new(&file.name()), Uint8Array::new(&bytes).to_vec()))
}
