//! Packages the page: JavaScript bindings of the WebAssembly program, compressed files, and a local server.

mod pack;
mod serve;

use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, bail};
use wasm_bindgen_cli_support::Bindgen;

const USAGE: &str = "usage: sonoglyph-web bind PROGRAM.wasm FOLDER | pack FOLDER | serve FOLDER PORT";

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let arguments: Vec<_> = arguments.iter().map(String::as_str).collect();
    let done = match arguments[..] {
        ["bind", program, folder] => bind(Path::new(program), Path::new(folder)),
        ["pack", folder] => pack::pack(Path::new(folder)),
        ["serve", folder, port] => {
            port.parse().context("PORT").and_then(|port| serve::serve(Path::new(folder), port))
        }
        _ => Err(anyhow::anyhow!(USAGE)),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

/// Writes `sonoglyph.js` and `sonoglyph_bg.wasm`.
fn bind(program: &Path, folder: &Path) -> anyhow::Result<()> {
    if !program.is_file() {
        bail!("{}: no such file", program.display());
    }
    let mut bindgen = Bindgen::new();
    bindgen.input_path(program).out_name("sonoglyph").web(true)?.typescript(false);
    bindgen.omit_default_module_path(false).generate(folder)
}
