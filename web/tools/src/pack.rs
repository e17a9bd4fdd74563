//! Compresses the files of a folder, and reports the size of a first visit.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use brotli::enc::BrotliEncoderParams;
use flate2::Compression;
use flate2::write::GzEncoder;

/// Extensions of compressible files.
const PACKED: [&str; 4] = ["wasm", "js", "html", "svg"];
/// Log2 of brotli's window: a whole program.
const WINDOW: i32 = 24;
const BEST: i32 = 11;

/// Writes a `.gz` and a `.br` beside each file, and prints their sizes.
pub fn pack(folder: &Path) -> anyhow::Result<()> {
    let mut sums = [0; 3];
    for path in files(folder)? {
        let ending = path.extension().unwrap_or_default().to_string_lossy().into_owned();
        if !PACKED.contains(&ending.as_str()) {
            continue;
        }
        let bytes = fs::read(&path).with_context(|| path.display().to_string())?;
        let (gzip, brotli) = (gzip(&bytes)?, brotli(&bytes)?);
        fs::write(path.with_extension(format!("{ending}.gz")), &gzip)?;
        fs::write(path.with_extension(format!("{ending}.br")), &brotli)?;
        let sizes = [bytes.len(), gzip.len(), brotli.len()];
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        println!("{}", line(&name, sizes));
        sums = std::array::from_fn(|i| sums[i] + sizes[i]);
    }
    println!("{}", line("together", sums));
    Ok(())
}

/// All files below a folder, sorted.
fn files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut entries: Vec<_> = fs::read_dir(folder)?.flatten().map(|entry| entry.path()).collect();
    entries.sort();
    let mut all = Vec::new();
    for path in entries {
        if path.is_dir() { all.extend(files(&path)?) } else { all.push(path) }
    }
    Ok(all)
}

fn line(name: &str, sizes: [usize; 3]) -> String {
    let [plain, gzip, brotli] = sizes.map(|bytes| bytes as f64 / 1e6);
    format!("{name:>18}: {plain:6.3} MB, gzip {gzip:6.3} MB, brotli {brotli:6.3} MB")
}

fn gzip(bytes: &[u8]) -> anyhow::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    Ok(encoder.finish()?)
}

fn brotli(bytes: &[u8]) -> anyhow::Result<Vec<u8>> {
    let parameters = BrotliEncoderParams { quality: BEST, lgwin: WINDOW, ..Default::default() };
    let mut packed = Vec::new();
    brotli::BrotliCompress(&mut &*bytes, &mut packed, &parameters)?;
    Ok(packed)
}
