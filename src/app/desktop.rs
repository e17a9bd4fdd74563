//! The window on the desktop: choice of the renderer, and fallback to OpenGL after a lost device.
//!
//! With a GPU the renderer is wgpu, on the device that computes the field: a map's texture is registered with egui
//! once and never passes through the CPU. Otherwise it is OpenGL, which costs a sixth of wgpu on a software driver,
//! and the CPU computes. `--renderer` overrides this.

use std::path::{Path, PathBuf};

use eframe::egui_wgpu::{WgpuSetup, WgpuSetupExisting};
use eframe::{egui, wgpu};

use crate::app::examples::{example, linked};
use crate::app::recovery::Recovery;
use crate::app::settings::{Memory, Settings};
use crate::app::window::{Legacy, TITLE, Window};
use crate::field::GpuError;
use crate::field::gpu::{adapter, device_descriptor};
use crate::scene::Scene;
use crate::studio::evaluator::Renderer;
use crate::studio::output::note;
use crate::studio::{link, still};
use crate::ui::document::Document;
use crate::ui::{Command, Editor, Notice, Purpose};

const SMALLEST: [f32; 2] = [200.0, 150.0];
/// Drawn from `assets/icon/sonoglyph.svg`.
const ICON: &[u8] = include_bytes!("../../assets/icon/sonoglyph.png");

/// The window's first step, beyond showing its document.
enum First {
    /// A drawing or a table is read.
    Read(Command),
    /// The scene could not be opened.
    Refused(anyhow::Error),
}

/// The document of an argument, and the window's first step with it.
fn start(path: &Path) -> anyhow::Result<(Document, Option<First>)> {
    if let Some(text) = path.to_str().filter(|text| link::is_link(text)) {
        return Ok((linked(text)?, None));
    }
    match Purpose::of_dropped(path) {
        Purpose::Open => Ok((Document::read(path)?, None)),
        purpose => Ok((blank(), Some(First::Read(purpose.command(path.to_owned()))))),
    }
}

fn blank() -> Document {
    Document::new(Scene::default(), "untitled")
}

/// Opens the window on a scene file, a drawing, a link, or an example; a file that cannot be read becomes a message in
/// the window. Without a display, writes the scene's sheet.
///
/// # Errors
/// Without a window, a scene that cannot be read; or a sheet that cannot be written.
pub fn run(path: Option<&Path>, renderer: Renderer) -> anyhow::Result<()> {
    let (document, first) = match path.map(start) {
        None => (example(0)?, None),
        Some(Ok(started)) => started,
        Some(Err(error)) if has_display() => (blank(), Some(First::Refused(error))),
        Some(Err(error)) => return Err(error),
    };
    let refusal = match &first {
        Some(First::Refused(error)) => Some(format!("{error:#}")),
        Some(First::Read(_)) => path.map(|path| format!("{}: only the window reads this", path.display())),
        None => None,
    };
    if let Err(error) = open(document, first, renderer) {
        if let Some(refusal) = refusal {
            anyhow::bail!("{refusal} (there is no window: {error})");
        }
        if path.is_some_and(|path| path.to_str().is_some_and(link::is_link)) {
            anyhow::bail!("there is no window ({error}) for the scene of a link");
        }
        note(&format!("there is no window ({error}): the scene's sheet is written instead"));
        still::default_sheet(path)?;
    }
    Ok(())
}

/// Whether a display is named; macOS and Windows always have one.
fn has_display() -> bool {
    !cfg!(all(unix, not(target_os = "macos"))) || display().is_some()
}

fn open(document: Document, first: Option<First>, renderer: Renderer) -> Result<(), String> {
    if !has_display() {
        return Err("no display".to_owned());
    }
    let (setup, lacking) = match setup(renderer) {
        Err(error) if renderer == Renderer::Auto => (None, Some(error)),
        setup => (setup.map_err(|error| error.to_string())?, None),
    };
    let legacy = Legacy::default();
    show(Editor::new(document), Said::Lacking(lacking, first), setup, &legacy)?;
    let left = legacy.borrow_mut().take();
    match left {
        Some((editor, notice)) => show(editor, Said::Notice(notice), None, &legacy),
        None => Ok(()),
    }
}

/// Messages for the opened window.
enum Said {
    /// The reason for not using a requested GPU, and the first step.
    Lacking(Option<GpuError>, Option<First>),
    Notice(Notice),
}

/// The device that computes the field and draws the window. `None`: the CPU computes and OpenGL draws, which costs a
/// sixth on software drivers.
fn setup(renderer: Renderer) -> Result<Option<WgpuSetup>, GpuError> {
    let found = match renderer {
        Renderer::Glow => return Ok(None),
        Renderer::Wgpu => adapter::best(true)?,
        Renderer::Auto => adapter::best(false)?,
    };
    let (instance, adapter) = found;
    let refused = |error: wgpu::RequestDeviceError| GpuError::Refused(error.to_string());
    let (device, queue) =
        pollster::block_on(adapter.request_device(&device_descriptor(&adapter))).map_err(refused)?;
    Ok(Some(WgpuSetup::Existing(WgpuSetupExisting { instance, adapter, device, queue })))
}

/// Runs the window until it is closed.
fn show(editor: Editor, said: Said, setup: Option<WgpuSetup>, legacy: &Legacy) -> Result<(), String> {
    let folder = state_folder();
    let (memory, settings, word) = match folder.as_deref().map(Memory::at) {
        Some((memory, settings, word)) => (Some(memory), settings, word),
        None => (None, Settings::default(), None),
    };
    let mut viewport = egui::ViewportBuilder::default()
        .with_title(TITLE)
        .with_app_id("sonoglyph")
        .with_inner_size(settings.size)
        .with_maximized(settings.maximized)
        .with_min_inner_size(SMALLEST);
    if let Some(position) = settings.position {
        viewport = viewport.with_position(position);
    }
    if let Ok(icon) = eframe::icon_data::from_png_bytes(ICON) {
        viewport = viewport.with_icon(icon);
    }
    let mut options = eframe::NativeOptions {
        renderer: if setup.is_some() { eframe::Renderer::Wgpu } else { eframe::Renderer::Glow },
        // There are no gradients, and dithering costs a software driver time per pixel.
        dithering: false,
        viewport,
        ..Default::default()
    };
    if let Some(setup) = setup {
        options.wgpu_options.wgpu_setup = setup;
    }
    let legacy = legacy.clone();
    let make: eframe::AppCreator<'_> = Box::new(move |context| {
        let mut window = Window::of(context, editor);
        window.remember(memory, &settings, word, &context.egui_ctx);
        window.recover(folder.as_deref().and_then(Recovery::at));
        window.leave_to(legacy);
        match said {
            Said::Notice(notice) => window.shown.notice = Some(notice),
            Said::Lacking(lacking, first) => {
                if let Some(error) = lacking {
                    note(&format!("{error}; the CPU computes the field"));
                }
                match first {
                    Some(First::Read(command)) => window.execute(command, &context.egui_ctx),
                    Some(First::Refused(error)) => {
                        note(&format!("{error:#}"));
                        window.refuse("The scene cannot be opened", &error);
                    }
                    None => {}
                }
            }
        }
        Ok(Box::new(window))
    });
    eframe::run_native(TITLE, options, make).map_err(|error| in_words(&error))
}

/// The display that the environment names, Wayland's before X11's, as winit chooses.
fn display() -> Option<String> {
    ["WAYLAND_DISPLAY", "DISPLAY"].into_iter().find_map(|name| {
        let value = std::env::var_os(name).filter(|value| !value.is_empty())?;
        Some(format!("{name}={}", value.to_string_lossy()))
    })
}

/// eframe's error as a message for the user.
fn in_words(error: &eframe::Error) -> String {
    let display = display().unwrap_or_else(|| "this desktop".to_owned());
    match error {
        eframe::Error::AppCreation(error) => error.to_string(),
        // winit's message is a source location, and a cause not available otherwise.
        eframe::Error::WinitEventLoop(_) => {
            format!("no display server answers at {display}, or its libraries are not installed")
        }
        eframe::Error::Winit(_) => format!("the display server at {display} opens no window"),
        eframe::Error::Glutin(error) => format!("no OpenGL at {display}: {error}"),
        eframe::Error::NoGlutinConfigs(_, error) => format!("no OpenGL at {display}: {error}"),
        eframe::Error::OpenGL(error) => format!("no usable OpenGL at {display}: {error}"),
        eframe::Error::Wgpu(error) => format!("no usable graphics driver at {display}: {error}"),
    }
}

/// The desktop's folder for persistent state, or `None`.
fn state_folder() -> Option<PathBuf> {
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let state = set("XDG_STATE_HOME")
        .or_else(|| set("LOCALAPPDATA"))
        .or_else(|| set("HOME").map(|home| home.join(".local").join("state")))?;
    Some(state.join("sonoglyph"))
}
