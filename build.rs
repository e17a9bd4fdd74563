//! Passes version, commit and compiler to the program, for `--version` and benchmark reports.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=SONOGLYPH_COMMIT");
    let commit =
        std::env::var("SONOGLYPH_COMMIT").map_or_else(|_| String::new(), |commit| format!(" ({commit})"));
    println!("cargo::rustc-env=SONOGLYPH_VERSION={}{commit}", env!("CARGO_PKG_VERSION"));
    let compiler =
        std::env::var_os("RUSTC").and_then(|rustc| Command::new(rustc).arg("--version").output().ok());
    if let Some(version) = compiler.and_then(|output| String::from_utf8(output.stdout).ok()) {
        println!("cargo::rustc-env=SONOGLYPH_RUSTC={}", version.trim());
    }
}
