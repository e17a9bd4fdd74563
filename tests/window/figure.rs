//! Exported figures of the map on the screen.

use super::*;

#[test]
fn a_figure_is_previewed_written_and_copied() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.svg");
    let mut screen = open();
    screen.get_by_label("Export").click();
    rest(&mut screen);
    screen.get_by_label("Figure…").click();
    rest(&mut screen);
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
    assert!(notice.text.starts_with("Copied 1004 x "), "{notice:?}");
    screen.get_by_label("Export…").click();
    rest(&mut screen);
    let purpose = Purpose::Export(sonoglyph::ui::Export::Figure(sonoglyph::picture::figure::Format::Svg));
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
    let purpose = Purpose::Export(sonoglyph::ui::Export::Figure(sonoglyph::picture::figure::Format::Svg));
    screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text: path.display().to_string() });
    rest(&mut screen);
    screen.key_press(Key::Enter);
    rest(&mut screen);
    let svg = std::fs::read_to_string(&path).unwrap();
    assert_eq!(svg.matches("</text>").count(), 1, "a scale bar, no depth bar and no axes");
    assert!(svg.contains(" mm</text>") && svg.matches("<image").count() == 1);
}
