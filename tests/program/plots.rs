//! Figures: PNG, SVG and PDF of one map agree; refusals.

use std::path::Path;
use std::process::Command;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::RgbImage;
use tempfile::TempDir;

const SCENE: &str = "format = 1\n[[target]]\nat = [0.01, 0.02, 0.1]\n[solver]\nmethod = \"focus\"\n\
                     [plane]\nsize = [0.12, 0.1]\n";

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), SCENE).unwrap();
    folder
}

/// The exit status, standard output and standard error.
fn run(folder: &Path, args: &[&str]) -> (Option<i32>, String, String) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_sonoglyph")).args(args).current_dir(folder).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

fn draw(folder: &Path, name: &str, more: &[&str]) -> Vec<u8> {
    let args = [&["render", "a.toml", "-o", name, "--figure", "--backend", "cpu"], more].concat();
    let (status, _, error) = run(folder, &args);
    assert_eq!((status, error.as_str()), (Some(0), ""), "{args:?}");
    std::fs::read(folder.join(name)).unwrap()
}

/// The largest picture in a PDF, among all streams.
fn map_of_pdf(bytes: &[u8]) -> RgbImage {
    let find = |from: usize, words: &[u8]| {
        bytes[from..].windows(words.len()).position(|window| window == words).map(|at| from + at)
    };
    let mut largest: Option<RgbImage> = None;
    let mut at = 0;
    while let Some(start) = find(at, b"/Subtype /Image") {
        let number = |key: &[u8]| -> u32 {
            let from = find(start, key).unwrap() + key.len();
            let digits: String = bytes[from..]
                .iter()
                .map(|&byte| char::from(byte))
                .skip_while(|c| *c == ' ')
                .take_while(char::is_ascii_digit)
                .collect();
            digits.parse().unwrap()
        };
        let (width, height) = (number(b"/Width"), number(b"/Height"));
        let data = find(start, b"stream\n").unwrap() + 7;
        let rgb = miniz_oxide::inflate::decompress_to_vec_zlib(&bytes[data..]).unwrap();
        let image = RgbImage::from_raw(width, height, rgb).unwrap();
        if largest.as_ref().is_none_or(|largest| image.len() > largest.len()) {
            largest = Some(image);
        }
        at = data;
    }
    largest.unwrap()
}

/// The first picture in an SVG, and its texts.
fn map_and_words_of_svg(bytes: &[u8]) -> (RgbImage, Vec<String>) {
    let text = std::str::from_utf8(bytes).unwrap();
    let document = roxmltree::Document::parse(text).unwrap();
    let named = |name: &'static str| document.descendants().filter(move |node| node.has_tag_name(name));
    let link = named("image").next().unwrap().attribute(("http://www.w3.org/1999/xlink", "href")).unwrap();
    let png = STANDARD.decode(link.strip_prefix("data:image/png;base64,").unwrap()).unwrap();
    let words = named("text").map(|node| node.text().unwrap().to_owned()).collect();
    (image::load_from_memory(&png).unwrap().to_rgb8(), words)
}

#[test]
fn all_three_formats_hold_the_same_map_and_text_stays_text() {
    let folder = folder();
    let choice = ["--title", "A focus & <more>", "--width-mm", "70", "--dpi", "200"];
    let png = image::load_from_memory(&draw(folder.path(), "a.png", &choice)).unwrap().to_rgb8();
    let pdf = draw(folder.path(), "a.pdf", &choice);
    let (map, words) = map_and_words_of_svg(&draw(folder.path(), "a.svg", &choice));
    assert!(map.width() > 300 && map == map_of_pdf(&pdf), "SVG and PDF hold the same picture");
    assert_eq!(png.width(), (70.0f64 * 200.0 / 25.4).round() as u32);
    // Pixel by pixel, without the frame around the map.
    let inside = |left: u32, top: u32| {
        let (columns, rows) = (4..map.width() - 4, 4..map.height() - 4);
        rows.into_iter()
            .all(|y| columns.clone().all(|x| png.get_pixel(left + x, top + y) == map.get_pixel(x, y)))
    };
    let corners =
        (0..png.width() - map.width()).flat_map(|x| (0..png.height() - map.height()).map(move |y| (x, y)));
    assert_eq!(
        corners.filter(|&(left, top)| inside(left, top)).count(),
        1,
        "the PNG holds the map at the same resolution"
    );
    for word in ["A focus & <more>", "x / mm", "y / mm", "−50", "RMS pressure / kPa", "0"] {
        assert!(words.iter().any(|own| own == word), "{word}: {words:?}");
    }
    assert!(pdf.starts_with(b"%PDF-") && pdf.windows(9).any(|window| window == b"/FontFile"));
}

#[test]
fn options_change_the_figure() {
    let folder = folder();
    let words = |more: &[&str]| map_and_words_of_svg(&draw(folder.path(), "a.svg", more)).1.join("|");
    let paths = |more: &[&str]| {
        let svg = draw(folder.path(), "a.svg", more);
        String::from_utf8(svg).unwrap().matches("<path").count()
    };
    assert!(words(&["--peak"]).contains("Peak pressure / "));
    assert!(words(&["--db", "--range=-40,0"]).contains("dB re"));
    assert!(words(&["--scale-bar"]).contains("20 mm"));
    assert!(words(&["--quantity", "phase"]).contains("−180"));
    let bare = paths(&[]);
    assert!(paths(&["--targets"]) == bare + 1 && paths(&["--contours=-6"]) > bare);
    let silent = |more: &[&str]| {
        let (map, _) = map_and_words_of_svg(&draw(folder.path(), "a.svg", more));
        *map.pixels().min_by_key(|pixel| pixel.0.iter().map(|&c| u32::from(c)).sum::<u32>()).unwrap()
    };
    assert!(silent(&[]).0.iter().all(|&c| c < 40), "dark where quiet");
    let (map, _) = map_and_words_of_svg(&draw(folder.path(), "a.svg", &["--light"]));
    assert!(map.pixels().any(|pixel| pixel.0.iter().all(|&c| c > 235)), "light where quiet");
}

#[test]
fn widths_are_those_of_solve() {
    let folder = folder();
    let (_, answer, error) = run(folder.path(), &["solve", "a.toml", "--json"]);
    let answer: serde_json::Value = serde_json::from_str(&answer).expect(&error);
    let widths = &answer["quality"]["widths"][0];
    let in_mm = |name: &str| format!("{:.1} mm", widths[name].as_f64().unwrap() * 1e3);
    let (_, words) = map_and_words_of_svg(&draw(folder.path(), "a.svg", &["--widths"]));
    for name in ["lateral_x", "lateral_y"] {
        assert!(words.contains(&in_mm(name)), "{name}: {} of {words:?}", in_mm(name));
    }
    let upright = SCENE
        .replace("[plane]", "[plane]\ncentre = [0.01, 0.02, 0.1]\nx_axis = [1, 0, 0]\ny_axis = [0, 0, 1]");
    std::fs::write(folder.path().join("a.toml"), upright).unwrap();
    let (_, words) = map_and_words_of_svg(&draw(folder.path(), "a.svg", &["--widths"]));
    assert!(
        words.iter().filter(|word| word.ends_with(" mm") && !word.contains('/')).count() == 2,
        "across and along: {words:?}"
    );
}

#[test]
fn a_shaded_surface_has_scale_bars_instead_of_axes() {
    let folder = folder();
    let choice = ["--quantity", "depression", "--view", "shaded", "--scale-bar", "--title", "Water"];
    // At the default amplitude the depression exceeds linear theory, which is a warning.
    let draw = |name: &str, more: &[&str]| {
        let args =
            [&["render", "a.toml", "-o", name, "--figure", "--backend", "cpu"], &choice[..], more].concat();
        let (status, _, error) = run(folder.path(), &args);
        assert_eq!(status, Some(0), "{args:?}: {error}");
        std::fs::read(folder.path().join(name)).unwrap()
    };
    let svg = draw("a.svg", &["--dpi", "150"]);
    let (surface, words) = map_and_words_of_svg(&svg);
    assert_eq!(words.len(), 3, "{words:?}");
    assert!(words[0] == "Water" && words.iter().any(|words| words == "20 mm"), "{words:?}");
    assert!(words.iter().any(|words| words.contains(" deep, drawn ") && words.ends_with(" ×")), "{words:?}");
    // The plane is 120 mm wide on 83 mm of paper: its bar of 20 mm is 13.83 mm there.
    let text = std::str::from_utf8(&svg).unwrap();
    let document = roxmltree::Document::parse(text).unwrap();
    let bars: Vec<[f64; 2]> = document
        .descendants()
        .filter(|node| node.has_tag_name("rect") && node.attribute("fill").is_some_and(|fill| fill != "#fff"))
        .map(|node| ["width", "height"].map(|side| node.attribute(side).unwrap().parse().unwrap()))
        .collect();
    assert!(bars.iter().any(|[width, _]| (width - 83.0 / 6.0).abs() < 0.05), "{bars:?}");
    assert!(bars.iter().any(|[width, height]| height > width && *height >= 2.4), "{bars:?}");
    let pdf = draw("a.pdf", &["--dpi", "150"]);
    assert!(surface == map_of_pdf(&pdf) && surface.width() == 490);
    // Water is blue.
    let middle = surface.get_pixel(surface.width() / 8, surface.height() / 2);
    assert!(middle[2] > middle[0] + 40, "{middle:?}");
    let png = image::load_from_memory(&draw("a.png", &["--dpi", "150"])).unwrap().to_rgb8();
    assert_eq!(png.width(), (85.0f64 * 150.0 / 25.4).round() as u32);
    let refused = |more: &[&str]| {
        let args = [&["render", "a.toml", "-o", "x.pdf", "--figure", "--view", "shaded"], more].concat();
        let (status, _, error) = run(folder.path(), &args);
        assert_eq!(status, Some(2), "{error}");
        error
    };
    assert!(refused(&[]).contains("--quantity depression"));
    assert!(
        refused(&["--quantity", "depression", "--contours=-6"]).contains("--contours applies to flat maps")
    );
}

#[test]
fn scenes_and_views_are_panels_of_one_page() {
    let folder = folder();
    std::fs::write(folder.path().join("b.toml"), SCENE.replace("0.01, 0.02", "-0.03, 0.0")).unwrap();
    let draw = |name: &str, more: &[&str]| {
        let args = [&["render", "-o", name, "--figure", "--backend", "cpu"], more].concat();
        let (status, _, error) = run(folder.path(), &args);
        assert_eq!((status, error.as_str()), (Some(0), ""), "{args:?}");
        std::fs::read(folder.path().join(name)).unwrap()
    };
    let svg = draw("page.svg", &["a.toml", "b.toml", "--columns", "2", "--width-mm", "174"]);
    let (_, words) = map_and_words_of_svg(&svg);
    assert!(words.contains(&"(a) a".to_owned()) && words.contains(&"(b) b".to_owned()), "{words:?}");
    let bars = words.iter().filter(|word| word.starts_with("RMS pressure / ")).count();
    assert_eq!(bars, 1, "both maps share a colour bar: {words:?}");
    let (_, words) = map_and_words_of_svg(&draw("drive.svg", &["a.toml", "--quantity", "drive"]));
    assert!(["phase / rad", "amplitude"].iter().all(|label| words.iter().any(|word| word == label)));
    let view = ["a.toml", "--view", "3d", "--dpi", "100", "--camera", "front"];
    let (picture, words) = map_and_words_of_svg(&draw("view.svg", &view));
    assert!(words.iter().any(|word| word == "z / mm") && picture == map_of_pdf(&draw("view.pdf", &view)));
    for (more, part) in [
        (&["--view", "3d", "--contours=-6"][..], "--contours applies to flat maps: leave out --view 3d"),
        (&["--quantity", "drive", "--db"], "--db applies to flat maps: leave out --quantity drive"),
        (&["--columns", "0"], "1..=12"),
    ] {
        let args = [&["render", "a.toml", "-o", "x.pdf", "--figure"], more].concat();
        let (status, _, error) = run(folder.path(), &args);
        assert!(status == Some(2) && error.contains(part), "{args:?}: {error}");
    }
}

#[test]
fn impossible_figures_are_refused_in_one_line() {
    let folder = folder();
    let render = |more: &[&'static str]| [&["render", "a.toml", "-o"], more].concat();
    for (args, part) in [
        (render(&["x.jpg"]), "x.jpg: this is written as .png; with --figure as .png, .svg or .pdf"),
        (render(&["x.svg"]), "with --figure"),
        (render(&["x.pdf"]), "with --figure"),
        (render(&["x.jpg", "--figure"]), "x.jpg: figures are written as .png, .svg and .pdf"),
        (render(&["x.pdf", "--figure", "--dpi", "0"]), "from 36 to 2400"),
        (render(&["x.pdf", "--figure", "--width-mm", "1e9"]), "from 30 to 1000"),
        (render(&["x.pdf", "--figure", "--range", "3"]), "two numbers"),
        (render(&["x.pdf", "--figure", "--contours", "6"]), "below 0"),
        (render(&["x.pdf", "--figure", "--quantity", "phase", "--db"]), "--db"),
        (render(&["x.pdf", "--figure", "--quantity", "sheet"]), "`sheet` is a page with axes of its own"),
        (render(&["x.png", "--dpi", "200"]), "--figure"),
        (render(&["x.png", "--figure", "--width-mm", "1000", "--dpi", "2400"]), "fewer dots per inch"),
        (vec!["rendr", "a.toml"], "rendr: no such command or file; did you mean `render`?"),
        (vec!["qqqq"], "qqqq: no such command or file"),
    ] {
        let (status, _, error) = run(folder.path(), &args);
        assert!(status == Some(2) && error.contains(part), "{args:?}: {status:?} {error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "{args:?} left something behind");
    }
}
