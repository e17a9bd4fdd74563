//! The Measure page: a scan of a microphone, what it tells of the array, and its calibration for the board.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::sync::Arc;

use num_complex::Complex64;
use sonoglyph::acoustics::Aperture;
use sonoglyph::device::calibration::Calibration;
use sonoglyph::drive::Drive;
use sonoglyph::measure::plan::{Raster, random_drives};
use sonoglyph::scene::Target;
use sonoglyph::ui::parts::measuring::Finding;
use sonoglyph::ui::{Export, Panel};

use crate::files::drop_file;

use super::*;

const DEAD: usize = 5;
const REVERSED: usize = 10;
/// An element that is late, and its phase in degrees.
const LATE: (usize, f64) = (3, 20.0);

/// A focus of a small array.
fn bench() -> Scene {
    let point = Target::new(Shape::Point { at: DVec3::new(0.0, 0.0, 0.1) });
    let mut scene = Scene { targets: vec![point], ..Scene::default() };
    (scene.array.rows, scene.array.columns, scene.solver.method) = (4, 4, Method::Naive);
    scene
}

/// Writes a scan of these drives, with a noise of 0.2 %.
fn write_scan(path: &Path, scene: &Scene, drives: &[Drive]) {
    let raster = Raster::over(scene);
    let places = Raster { size: 1.5 * raster.size, ..raster }.places();
    let mut gains = vec![Complex64::ONE; scene.elements()];
    (gains[DEAD], gains[REVERSED]) = (Complex64::ZERO, -Complex64::ONE);
    gains[LATE.0] = Complex64::from_polar(1.0, LATE.1.to_radians());
    let aperture = Aperture::new(scene);
    let transfer = aperture.transfer(&places);
    let mut csv = "x,y,z,re,im,drive\n".to_owned();
    for (number, drive) in drives.iter().enumerate() {
        let excitation = drive.excitation(&aperture.driven);
        let played: Vec<_> = excitation.iter().zip(&aperture.driven).map(|(u, &n)| u * gains[n]).collect();
        let pressures = transfer.pressure(&played);
        let squares: f64 = pressures.iter().map(|p| p.norm_sqr()).sum();
        let noise = 0.002 * (squares / pressures.len() as f64).sqrt();
        for (index, (at, p)) in places.iter().zip(&pressures).enumerate() {
            let p = p + Complex64::from_polar(noise, TAU * (0.618 * index as f64 + 0.41 * number as f64));
            let DVec3 { x, y, z } = *at;
            writeln!(csv, "{x:?},{y:?},{z:?},{:?},{:?},{number}", p.re, p.im).unwrap();
        }
    }
    std::fs::write(path, csv).unwrap();
}

/// A folder with a scan and its drives.
fn folder_of(scene: &Scene) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let drives = random_drives(scene, 2, 16, 1);
    write_scan(&folder.path().join("scan.csv"), scene, &drives);
    let text = Drive::write_in_turn(&drives, &Aperture::new(scene));
    std::fs::write(folder.path().join("drive.csv"), text).unwrap();
    folder
}

fn open_on(scene: &Scene) -> Screen {
    let mut screen = open();
    screen.state_mut().editor_mut().replace(Document::new(scene.clone(), "bench"));
    screen.set_size(vec2(1280.0, 1600.0));
    rest(&mut screen);
    screen
}

fn press_button(screen: &mut Screen, name: &str) {
    screen.get_by_role_and_label(egui::accesskit::Role::Button, name).click();
    rest(screen);
}

fn finding(screen: &Screen) -> Arc<Finding> {
    let exact = screen.state().editor().parts.measuring.exact().expect("a fit");
    Arc::clone(exact.unwrap())
}

fn has_fact(finding: &Finding, name: &str, value: &str) -> bool {
    finding.facts.iter().any(|(own, text)| own == name && text == value)
}

#[test]
fn an_opened_scan_shows_verdict_and_elements() {
    let scene = bench();
    let folder = folder_of(&scene);
    let mut screen = open_on(&scene);
    page(&screen, "Measure").unwrap().click();
    rest(&mut screen);
    assert!(screen.query_by_label_contains("--plan").is_some(), "how to make a scan");
    press_button(&mut screen, "Open scan…");
    answer(&mut screen, Purpose::Scan, &folder.path().join("scan.csv"));
    let found = finding(&screen);
    screen.get_by_label(&found.verdict);
    assert!(found.measured.is_identifiable(), "{:?}", found.warnings);
    assert!(has_fact(&found, "Dead", &DEAD.to_string()), "{:?}", found.facts);
    assert!(has_fact(&found, "Reversed", &REVERSED.to_string()), "{:?}", found.facts);
    screen.get_by_label("Reversed");
    screen.get_by_label("drive.csv");

    // Targets do not matter beside drives from a file; air does.
    screen.state_mut().editor_mut().document.scene.targets[0].pressure = 100.0;
    rest(&mut screen);
    assert!(Arc::ptr_eq(&found, &finding(&screen)), "computed again");
    screen.state_mut().editor_mut().document.scene.array.strength *= 2.0;
    rest(&mut screen);
    let weaker = finding(&screen);
    let ratio = weaker.measured.fit.scale.value / found.measured.fit.scale.value;
    assert!((ratio - 0.5).abs() < 1e-3, "{ratio}");
    assert!(screen.run() <= 2, "an idle page requests no frames");

    screen.get_by_label("Microphone width").click();
    rest(&mut screen);
    type_in(&mut screen, "Width of the microphone", "3");
    assert_eq!(screen.state().editor().parts.measuring.form.width, Some(0.003));
    assert!(!Arc::ptr_eq(&weaker, &finding(&screen)));
}

#[test]
fn a_dropped_bad_scan_shows_its_line() {
    let scene = bench();
    let folder = folder_of(&scene);
    let mut screen = open_on(&scene);
    let good = folder.path().join("scan.csv");
    drop_file(&mut screen, &good);
    assert_eq!(screen.state().editor().panel, Panel::Measure);
    let verdict = finding(&screen).verdict.clone();
    screen.get_by_label(&verdict);
    assert_eq!(*super::scene(&screen), scene);

    let bad = folder.path().join("bad.csv");
    std::fs::write(&bad, "x,y,z,re,im\n0,0,0.1,1,1\n0,0,0.1,one,1\n").unwrap();
    drop_file(&mut screen, &bad);
    screen.get_by_label_contains("bad.csv:3:");
    assert!(screen.query_by_label(&verdict).is_none(), "the result is of another file");
    assert!(screen.query_by_label("Save calibration…").is_none());
    // Mended and read again.
    std::fs::copy(&good, &bad).unwrap();
    press_button(&mut screen, "Read again");
    screen.get_by_label(&verdict);
}

#[test]
fn a_scan_without_drives_takes_the_scenes_or_a_chosen_file() {
    let scene = bench();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.csv");
    let mut screen = open_on(&scene);
    let solution = screen.state().shown().solution.clone().unwrap();
    write_scan(&path, &scene, &solution.drives());
    drop_file(&mut screen, &path);
    screen.get_by_label("the scene's");
    assert!(has_fact(&finding(&screen), "Dead", &DEAD.to_string()));
    let drives = random_drives(&scene, 1, 16, 7);
    write_scan(&path, &scene, &drives);
    let other = folder.path().join("other.csv");
    std::fs::write(&other, Drive::write_in_turn(&drives, &Aperture::new(&scene))).unwrap();
    press_button(&mut screen, "Choose…");
    answer(&mut screen, Purpose::ScanDrive, &other);
    screen.get_by_label("other.csv");
    assert!(has_fact(&finding(&screen), "Dead", &DEAD.to_string()));
    press_button(&mut screen, "Default");
    screen.get_by_label("the scene's");
}

#[test]
fn the_board_uses_the_saved_calibration() {
    let scene = bench();
    let folder = folder_of(&scene);
    let mut screen = open_on(&scene);
    drop_file(&mut screen, &folder.path().join("scan.csv"));
    press_button(&mut screen, "Use for this board");
    let purpose = Purpose::Export(Export::Calibration { is_used: true });
    let path = folder.path().join("calibration.csv");
    let text = path.display().to_string();
    assert_eq!(screen.state().editor().dialog, Some(Dialog::Path { purpose, text: text.clone() }));
    key(&mut screen, Key::Enter);
    assert_eq!(screen.state().editor().dialog, None);
    assert_eq!(screen.state().editor().board.calibration, text);
    screen.get_by_label_contains("The Device page uses calibration.csv");
    assert_eq!(Calibration::read(&path, &scene).unwrap().off(), [DEAD]);
    let csv = std::fs::read_to_string(&path).unwrap();
    let offset = |element: usize| -> f64 {
        csv.lines().nth(element + 1).unwrap().split(',').nth(1).unwrap().parse().unwrap()
    };
    let late = offset(LATE.0) - offset(0);
    assert!((late - LATE.1).abs() < 1.0, "{late}");
    let reversed = (offset(REVERSED) - offset(0)).abs();
    assert!((reversed - 180.0).abs() < 1.0, "{reversed}");

    // Saved already: it is used at once.
    screen.state_mut().editor_mut().board.calibration.clear();
    press_button(&mut screen, "Use for this board");
    assert_eq!((&screen.state().editor().dialog, &screen.state().editor().board.calibration), (&None, &text));
    // That with gains is another one.
    screen.get_by_label("Gains, too (less pressure)").click();
    rest(&mut screen);
    press_button(&mut screen, "Use for this board");
    assert!(matches!(screen.state().editor().dialog, Some(Dialog::Path { .. })));
}

#[test]
fn the_figure_is_enlarged_and_written() {
    let scene = bench();
    let folder = folder_of(&scene);
    let mut screen = open_on(&scene);
    drop_file(&mut screen, &folder.path().join("scan.csv"));
    press_button(&mut screen, "Enlarge");
    assert_eq!(screen.state().editor().dialog, Some(Dialog::Measured));
    screen.get_by_label("Figure of the measured field, enlarged");
    key(&mut screen, Key::Escape);
    assert_eq!(screen.state().editor().dialog, None);
    assert!(screen.state().shown().measured.is_some());
    assert!(screen.state().shown().measured_large.is_none());
    press_button(&mut screen, "Save report…");
    let path = folder.path().join("own.svg");
    let (purpose, text) = (Purpose::Export(Export::Report), path.display().to_string());
    screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text });
    key(&mut screen, Key::Enter);
    let svg = std::fs::read_to_string(&path).unwrap();
    assert!(roxmltree::Document::parse(&svg).unwrap().root_element().has_tag_name("svg"));
}
