//! Exported figures of what is on the screen.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::RgbImage;
use sonoglyph::ui::{Export, Piece};

use super::*;

/// Opens the dialog of figures.
fn open_dialog(screen: &mut Screen) {
    for label in ["Export", "Figure…"] {
        screen.get_by_label(label).click();
        rest(screen);
    }
}

/// Exports the figure of the open dialog as SVG, and opens the dialog again.
fn svg(screen: &mut Screen) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.svg");
    let form = screen.state().editor().figure.clone();
    key(screen, Key::Enter);
    let Some(Dialog::Path { purpose: Purpose::Export(Export::Figure(_)), .. }) =
        screen.state().editor().dialog
    else {
        panic!("Enter saves: {:?}", screen.state().editor().dialog)
    };
    let purpose = Purpose::Export(Export::Figure(sonoglyph::picture::figure::Format::Svg));
    screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text: path.display().to_string() });
    key(screen, Key::Enter);
    let svg = std::fs::read_to_string(&path).unwrap();
    open_dialog(screen);
    screen.state_mut().editor_mut().figure = form;
    rest(screen);
    svg
}

/// The pictures and the texts in an SVG; colour bars are pictures too.
fn parts(svg: &str) -> (Vec<RgbImage>, Vec<String>) {
    let document = roxmltree::Document::parse(svg).unwrap();
    let named = |name: &'static str| document.descendants().filter(move |node| node.has_tag_name(name));
    let picture = |node: roxmltree::Node<'_, '_>| {
        let link = node.attribute(("http://www.w3.org/1999/xlink", "href")).unwrap();
        let png = STANDARD.decode(link.strip_prefix("data:image/png;base64,").unwrap()).unwrap();
        image::load_from_memory(&png).unwrap().to_rgb8()
    };
    let words = named("text").map(|node| node.text().unwrap().to_owned()).collect();
    (named("image").map(picture).collect(), words)
}

/// The picture of the screen, as *View as PNG* writes it.
fn view(screen: &mut Screen) -> RgbImage {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("view.png");
    for label in ["Export", "View as PNG…"] {
        screen.get_by_label(label).click();
        rest(screen);
    }
    let purpose = Purpose::Export(Export::Map);
    screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text: path.display().to_string() });
    key(screen, Key::Enter);
    image::open(path).unwrap().to_rgb8()
}

/// Ticks a panel of the open dialog.
fn tick(screen: &mut Screen, piece: &str) {
    let ticks = screen.query_all_by_role_and_label(egui::accesskit::Role::CheckBox, piece);
    ticks.last().unwrap().click();
    rest(screen);
}

/// Chooses from the list of extents; other parts of the window have the same words.
fn choose_extent(screen: &mut Screen, entry: &str) {
    let list = screen.get_by_role_and_label(egui::accesskit::Role::ComboBox, "Extent");
    let place = list.rect().center();
    list.click();
    rest(screen);
    let near = |node: &egui_kittest::Node<'_>| (node.rect().center() - place).length();
    let entries = screen.query_all_by_label(entry);
    entries.min_by(|a, b| near(a).total_cmp(&near(b))).unwrap().click();
    rest(screen);
}

/// The part of pixels that are the same in a figure, at the resolution at which it has as many as the screen.
fn agreement(screen: &mut Screen) -> f64 {
    let view = view(screen);
    open_dialog(screen);
    let mut dpi = 300.0;
    for _ in 0..6 {
        type_in(screen, "Resolution", &format!("{dpi:.1}"));
        let (pictures, _) = parts(&svg(screen));
        let own = &pictures[0];
        if own.dimensions() == view.dimensions() {
            let same = own.pixels().zip(view.pixels()).filter(|(own, view)| own == view).count();
            return same as f64 / f64::from(view.width() * view.height());
        }
        let wider = f64::from(view.width()) / f64::from(own.width());
        dpi = if wider == 1.0 { dpi + 0.1 } else { dpi * wider };
    }
    panic!("no resolution gives {:?} pixels", view.dimensions())
}

#[test]
fn figures_have_the_pixels_of_the_screen() {
    let mut screen = open();
    assert!(agreement(&mut screen) > 0.999, "the map");
    key(&mut screen, Key::Escape);
    screen.get_by_label("3D").click();
    rest(&mut screen);
    assert!(agreement(&mut screen) > 0.999, "the 3D view, whose labels are text");
    let (pictures, words) = parts(&svg(&mut screen));
    assert_eq!(pictures.len(), 2, "the view and its bar");
    for word in ["x / mm", "y / mm", "z / mm", "RMS pressure / "] {
        assert!(words.iter().any(|own| own.starts_with(word)), "{word}: {words:?}");
    }
    assert!(words.iter().any(|own| own.starts_with("Surface at −6.0 dB: ")), "{words:?}");
}

#[test]
fn a_compared_pair_has_one_range_and_one_bar() {
    let mut screen = open();
    screen.get_by_role_and_label(egui::accesskit::Role::CheckBox, "Compare").click();
    rest(&mut screen);
    screen.state_mut().editor_mut().compare.as_mut().unwrap().method = Method::Wgs;
    rest(&mut screen);
    open_dialog(&mut screen);
    assert_eq!(screen.state().editor().figure.pieces, [Piece::Map, Piece::Second]);
    let (pictures, words) = parts(&svg(&mut screen));
    let [left, right, bar] = &pictures[..] else { panic!("{} pictures", pictures.len()) };
    assert_eq!(left.dimensions(), right.dimensions());
    assert!(bar.width() < 60 && bar.height() == left.height() && left != right);
    assert_eq!(words.iter().filter(|own| own.starts_with("RMS pressure / ")).count(), 1, "{words:?}");
    let titles = [format!("(a) {}", Method::Naive.title()), format!("(b) {}", Method::Wgs.title())];
    assert!(titles.iter().all(|title| words.contains(title)), "{words:?}");
    // The last colour is that of the larger of both peaks.
    let last = sonoglyph::picture::ColourMap::Inferno.table()[255];
    let reaches = |map: &RgbImage| map.pixels().any(|pixel| pixel.0[..] == last[..3]);
    assert_ne!(reaches(left), reaches(right));
    tick(&mut screen, "Difference");
    let (pictures, words) = parts(&svg(&mut screen));
    assert_eq!(pictures.len(), 5, "a third map with its own bar");
    assert!(words.iter().any(|word| word.starts_with("Difference / ")), "{words:?}");
}

#[test]
fn drive_profile_and_methods_are_panels_of_a_page() {
    let mut screen = open();
    screen.state_mut().editor_mut().view.section = true;
    rest(&mut screen);
    open_dialog(&mut screen);
    assert_eq!(screen.state().editor().figure.pieces, [Piece::Map, Piece::Profile]);
    for label in ["Map", "Phases", "Amplitudes"] {
        tick(&mut screen, label);
    }
    let (pictures, words) = parts(&svg(&mut screen));
    assert_eq!(pictures.len(), 2, "two colour bars alone");
    for word in ["phase / rad", "amplitude", "−π", "Pressure / Pa RMS", "(b) Phase per element"] {
        assert!(words.iter().any(|own| own == word), "{word}: {words:?}");
    }
    let texts = words.join("|");
    assert!(!texts.contains('-') && !texts.contains("−0|"), "{texts}");
}

#[test]
fn the_extent_of_a_figure_is_chosen() {
    let mut screen = open();
    let at = lens(&screen).rect.center();
    turn_wheel(&mut screen, at);
    open_dialog(&mut screen);
    let shape = |screen: &mut Screen| {
        let (pictures, words) = parts(&svg(screen));
        (f64::from(pictures[0].width()) / f64::from(pictures[0].height()), words)
    };
    let size = lens(&screen).size();
    assert!((shape(&mut screen).0 - size.x / size.y).abs() < 0.01, "as on the screen");
    choose_extent(&mut screen, "Scene plane");
    let plane = scene(&screen).plane.size;
    assert!((shape(&mut screen).0 - plane.x / plane.y).abs() < 0.01);
    choose_extent(&mut screen, "Width x height");
    type_in(&mut screen, "Width of the extent", "80");
    type_in(&mut screen, "Height of the extent", "20");
    let (shape, words) = shape(&mut screen);
    assert!((shape - 4.0).abs() < 0.05 && words.iter().any(|word| word == "−40"), "{shape} {words:?}");
    assert!(!words.iter().any(|word| word == "−60"), "{words:?}");
}

#[test]
fn a_figure_is_previewed_written_and_copied() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.svg");
    let mut screen = open();
    open_dialog(&mut screen);
    let size = |screen: &Screen| {
        let preview =
            screen.state().shown().figure.as_ref().expect("the dialog has a preview").as_ref().unwrap();
        preview.size
    };
    assert!((size(&screen)[0] - 85.0).abs() < 0.2, "{:?}", size(&screen));
    screen.get_by_label("Colour bar").click();
    screen.get_by_label("Scale bar").click();
    rest(&mut screen);
    screen.get_by_label("Copy image").click();
    rest(&mut screen);
    let notice = screen.state().shown().notice.as_ref().unwrap();
    assert!(notice.text.starts_with("Copied 1004 × "), "{notice:?}");
    screen.get_by_label("Export…").click();
    rest(&mut screen);
    let purpose = Purpose::Export(Export::Figure(sonoglyph::picture::figure::Format::Svg));
    let wrong = folder.path().join("own.jpg");
    for path in [&wrong, &path] {
        let text = path.display().to_string();
        screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text });
        rest(&mut screen);
        screen.key_press(Key::Enter);
        rest(&mut screen);
    }
    assert!(!wrong.exists(), "an unknown ending is refused");
    let svg = std::fs::read_to_string(&path).unwrap();
    assert!(svg.contains(" mm</text>") && !svg.contains("RMS pressure"), "a scale bar and no colour bar");
}

#[test]
fn the_figure_of_a_shaded_surface_is_shaded() {
    let mut screen = open();
    export_shaded(&mut screen, "Figure…");
    assert!(screen.query_by_label("Contours").is_none(), "a shaded surface has no contours");
    screen.get_by_label("Depth bar").click();
    screen.get_by_label("Scale bar").click();
    rest(&mut screen);
    screen.get_by_label("Export…").click();
    rest(&mut screen);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.svg");
    let purpose = Purpose::Export(Export::Figure(sonoglyph::picture::figure::Format::Svg));
    screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text: path.display().to_string() });
    rest(&mut screen);
    screen.key_press(Key::Enter);
    rest(&mut screen);
    let svg = std::fs::read_to_string(&path).unwrap();
    assert_eq!(svg.matches("</text>").count(), 1, "a scale bar, no depth bar and no axes");
    assert!(svg.contains(" mm</text>") && svg.matches("<image").count() == 1);
}
