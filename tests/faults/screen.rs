//! A missing display, or one without graphics: the program writes the sheet instead, and says why.

use std::path::Path;
use std::process::{Command, Output};

use crate::{folder, listing, program};

/// Asserts that the sheet was written in place of a window, with this reason.
fn sheet_of(output: &Output, folder: &Path, why: &str) {
    let noted = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !noted.contains("panicked"), "{:?}: {noted}", output.status);
    assert!(noted.contains("there is no window (") && noted.contains(why), "{noted}");
    assert!(!noted.contains(".rs:"), "no source locations: {noted}");
    assert_eq!(noted.matches("the CPU computes the field").count(), 1, "{noted}");
    assert!(listing(folder).contains(&"sonoglyph.png".to_owned()));
}

#[test]
fn without_a_display_the_sheet_is_written() {
    let nowhere = ("VK_DRIVER_FILES", "/nonexistent/icd.json");
    for (name, value) in
        [("DISPLAY", ":4711"), ("DISPLAY", "no such screen"), ("WAYLAND_DISPLAY", "wayland-4711")]
    {
        if !cfg!(feature = "window") {
            continue;
        }
        let folder = folder();
        let output = program(folder.path(), &["a.toml"]).envs([nowhere, (name, value)]).output().unwrap();
        sheet_of(&output, folder.path(), &format!("no display server answers at {name}={value}, "));
    }
    let folder = folder();
    let output = program(folder.path(), &["a.toml"]).envs([nowhere]).output().unwrap();
    if cfg!(feature = "window") {
        sheet_of(&output, folder.path(), "no display");
    }
}

#[cfg(feature = "window")]
#[test]
fn without_graphics_the_sheet_is_written() {
    use std::io::{BufRead, BufReader};
    use std::process::Stdio;

    let server = Command::new("Xvfb")
        .args(["-displayfd", "1", "-screen", "0", "640x480x24", "-nolisten", "tcp", "-extension", "GLX"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn();
    let server = crate::requirement::found("display", server.map_err(|error| format!("Xvfb: {error}")));
    let Some(mut server) = server.map(crate::Running) else { return };
    let mut number = String::new();
    BufReader::new(server.0.stdout.take().unwrap()).read_line(&mut number).unwrap();
    let folder = folder();
    let output = program(folder.path(), &["a.toml"])
        .env("DISPLAY", format!(":{}", number.trim()))
        .env("VK_DRIVER_FILES", "/nonexistent/icd.json")
        .env("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent/egl.json")
        .env("LIBGL_DRIVERS_PATH", "/nonexistent")
        .output()
        .unwrap();
    sheet_of(&output, folder.path(), &format!("OpenGL at DISPLAY=:{}", number.trim()));
}

#[test]
fn without_a_driver_devices_says_so_and_a_requested_gpu_is_an_error() {
    let folder = folder();
    let without = |args: &[&str]| {
        let mut command = program(folder.path(), args);
        command
            .env("VK_DRIVER_FILES", "/nonexistent/icd.json")
            .env("VK_ICD_FILENAMES", "/nonexistent/icd.json");
        command
    };
    let said = crate::succeed(&mut without(&["devices"]));
    assert!(said.contains("none: no graphics driver offers one"), "{said}");
    for quantity in ["rms", "dent", "sheet"] {
        let args = ["render", "a.toml", "-o", "x.png", "--backend", "gpu", "--quantity", quantity];
        let message = crate::refused(&mut without(&args));
        assert!(message.contains("no usable GPU adapter: no graphics driver offers one"), "{message}");
    }
    assert_eq!(listing(folder.path()), ["a.toml"]);
}
