//! Scenes as links: the file's text, compressed (deflate) and encoded (base64url), after `sonoglyph:#` or the address
//! of a page.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use miniz_oxide::deflate::compress_to_vec;
use miniz_oxide::inflate::decompress_to_vec_with_limit;
use thiserror::Error;

use crate::echo;
use crate::scene::file::{self, FileError, LONGEST};
use crate::scene::{BodyKind, Scene};
use crate::studio::arrays;

/// Scheme of links without a page, and prefixes of page addresses.
const SCHEME: &str = "sonoglyph:";
const PAGES: [&str; 2] = ["https://", "http://"];
/// Deflate's smallest output; a scene takes a millisecond.
const LEVEL: u8 = 9;
/// Name of a link in messages.
const NAME: &str = "link";

#[derive(Debug, Error)]
pub enum LinkError {
    #[error(
        "incomplete Sonoglyph link: must be “sonoglyph:#” or a page with #, followed by letters, digits, - and _"
    )]
    Broken,
    #[error("the scene in this link is larger than {} MiB", LONGEST >> 20)]
    TooLarge,
    #[error("the link holds no scene of this program: {0}")]
    Scene(#[from] FileError),
    #[error("a link holds no pictures: the scene has “{}”", echo::value(.0))]
    Picture(String),
    #[error("a link holds no waveforms: the modulation has “{}”", echo::value(.0))]
    Wave(String),
    #[error("a link holds no paths: the motion has “{}”", echo::value(.0))]
    Path(String),
    #[error("a link holds no tables: the array has “{}”", echo::value(.0))]
    Table(String),
    #[error("a link holds no meshes: the body has “{}”", echo::value(.0))]
    Mesh(String),
    #[error("a link holds no drives: the scene plays “{}”", echo::value(.0))]
    Drive(String),
}

/// Whether a text looks like a link, possibly a broken one.
pub fn is_link(text: &str) -> bool {
    let text = text.trim_start();
    text.starts_with(SCHEME) || (PAGES.iter().any(|page| text.starts_with(page)) && text.contains('#'))
}

/// The link of a page address' fragment.
pub fn of_letters(letters: &str) -> String {
    format!("{SCHEME}#{letters}")
}

/// The link as the address of a page that opens it.
pub fn of_page(link: &str, page: &str) -> String {
    link.replacen(SCHEME, page, 1)
}

/// The link of a scene.
///
/// # Errors
/// A scene with pictures, drives, a waveform, paths, tables or meshes, which are separate files.
pub fn write(scene: &Scene) -> Result<String, LinkError> {
    for target in &scene.targets {
        if let Some((file, ..)) = target.shape.picture() {
            return Err(LinkError::Picture(file.to_owned()));
        }
    }
    if scene.drive.is_named() {
        return Err(LinkError::Drive(scene.drive.name.clone()));
    }
    if let Some((_, named)) = scene.modulations().find(|(_, modulation)| !modulation.file.is_empty()) {
        return Err(LinkError::Wave(named.file.clone()));
    }
    let own = scene.targets.iter().filter_map(|target| target.motion.as_ref());
    if let Some(motion) = own.chain([&scene.motion]).find(|motion| !motion.file.is_empty()) {
        return Err(LinkError::Path(motion.file.clone()));
    }
    let tables = [&scene.array.file, &scene.array.wiring, &scene.array.directivity];
    if let Some(name) = tables.into_iter().flatten().find(|name| !name.starts_with(arrays::PRESET)) {
        return Err(LinkError::Table(name.clone()));
    }
    if let Some(file) =
        scene.bodies.iter().filter(|body| body.kind == BodyKind::Mesh).find_map(|it| it.file.clone())
    {
        return Err(LinkError::Mesh(file));
    }
    let packed = compress_to_vec(file::write(scene).as_bytes(), LEVEL);
    Ok(of_letters(&URL_SAFE_NO_PAD.encode(packed)))
}

/// The scene file's text of a link.
///
/// # Errors
/// A broken or too large link, or a scene that is invalid or names files.
pub fn read(link: &str) -> Result<String, LinkError> {
    let letters = Some(link.trim()).filter(|link| is_link(link)).and_then(|link| link.split_once('#'));
    let letters = letters.map(|(_, letters)| letters);
    // Mail programs break long lines.
    let letters: String = letters.ok_or(LinkError::Broken)?.chars().filter(|c| !c.is_whitespace()).collect();
    let packed = URL_SAFE_NO_PAD.decode(letters.trim_end_matches('=')).map_err(|_| LinkError::Broken)?;
    let text =
        decompress_to_vec_with_limit(&packed, LONGEST as usize).map_err(|error| match error.status {
            miniz_oxide::inflate::TINFLStatus::HasMoreOutput => LinkError::TooLarge,
            _ => LinkError::Broken,
        })?;
    let text = String::from_utf8(text).map_err(|_| LinkError::Broken)?;
    let scene = file::parse(&text, Path::new(NAME))?;
    // A link from elsewhere opens no file of this machine.
    write(&scene).map(|_| text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_comes_back_from_its_link() {
        let scene = file::parse(crate::studio::EXAMPLE, Path::new("hit.toml")).unwrap();
        let link = write(&scene).unwrap();
        assert!(link.starts_with("sonoglyph:#") && is_link(&link), "{link}");
        assert!(link["sonoglyph:#".len()..].chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c)));
        assert!(link.len() < 1500, "{} letters", link.len());
        let broken = link.as_bytes().chunks(70).map(|line| std::str::from_utf8(line).unwrap());
        let mailed = format!(" {}\n", broken.collect::<Vec<_>>().join("\n"));
        let page = of_page(&link, "https://example.org/sonoglyph/");
        assert!(page.starts_with("https://example.org/sonoglyph/#"), "{page}");
        for link in [mailed, page] {
            let read = file::parse(&read(&link).unwrap(), Path::new(NAME)).unwrap();
            assert_eq!(read, scene);
        }
    }

    #[test]
    fn broken_and_boundless_links_are_refused() {
        let good = write(&Scene::default()).unwrap();
        for bad in ["sonoglyph:", "sonoglyph:#", "sonoglyph:#&&&", "http://a/#b", &good[..good.len() - 9]] {
            assert!(matches!(read(bad), Err(LinkError::Broken)), "{bad}");
        }
        let link = |text: &[u8]| format!("{SCHEME}#{}", URL_SAFE_NO_PAD.encode(compress_to_vec(text, LEVEL)));
        let with_wave = link(b"format = 1\n[modulation]\nfile = \"/etc/passwd\"\n");
        assert!(matches!(read(&with_wave), Err(LinkError::Wave(_))));
        assert!(matches!(read(&link(&vec![b' '; 64 << 20])), Err(LinkError::TooLarge)));
        assert!(matches!(read(&link(b"[array]\npitch = 1e9\n")), Err(LinkError::Scene(_))));
        assert!(matches!(read(&link(&[0xff, 0xfe])), Err(LinkError::Broken)));
        let picture = "format = 1\n[[target]]\nkind = \"picture\"\nfile = \"/etc/a.png\"\nat = [0, 0, 0.1]\nwidth = 0.05\n";
        assert!(matches!(read(&link(picture.as_bytes())), Err(LinkError::Picture(_))));
    }
}
