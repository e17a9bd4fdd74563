//! The skin: thresholds by name and from files, and what is felt of a scene.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use sonoglyph::scene::{Skin, Threshold};
use sonoglyph::solver;
use sonoglyph::studio::felt::{FLOOR, Felt};
use sonoglyph::studio::opening;
use sonoglyph::studio::paintings::Paintings;
use strum::VariantArray;

/// Hz and µm (peak), of Morioka and Griffin's accelerations.
const HAND: [[f64; 2]; 17] = [
    [8.0, 53.2],
    [10.0, 35.8],
    [12.5, 21.8],
    [16.0, 15.1],
    [20.0, 13.4],
    [25.0, 9.17],
    [31.5, 3.94],
    [40.0, 1.46],
    [50.0, 1.03],
    [63.0, 0.442],
    [80.0, 0.157],
    [100.0, 0.0824],
    [125.0, 0.0504],
    [160.0, 0.0294],
    [200.0, 0.0260],
    [250.0, 0.0183],
    [315.0, 0.0220],
];

fn known(threshold: Threshold) -> Skin {
    let name: &str = threshold.into();
    Skin { threshold: name.to_owned(), ..Skin::default() }
}

/// Whether two are equal to the digits of the table.
fn is_near(value: f64, other: f64) -> bool {
    (value / other - 1.0).abs() < 0.006
}

#[test]
fn thresholds_equal_their_sources() {
    let hand = known(Threshold::Hand);
    for [frequency, micrometres] in HAND {
        let own = hand.threshold_at(frequency) * 1e6;
        assert!(is_near(own, micrometres), "{frequency} Hz: {own} µm");
    }
    let curve = known(Threshold::Psychohaptic);
    let at = |frequency: u32| curve.threshold_at(f64::from(frequency));
    assert_eq!((20..=400).min_by(|&a, &b| at(a).total_cmp(&at(b))), Some(250));
    assert!((at(250) / hand.threshold_at(250.0) - 1.0).abs() < 1e-12);
    // L(50) - L(250) of the reference software.
    let level = 62.0 * (7.0f64 / 11.0).log10().powi(2) / (6.0f64 / 11.0).log10().powi(2);
    assert!((20.0 * (at(50) / at(250)).log10() - level).abs() < 1e-9);
    let afferents = known(Threshold::Afferents);
    for (frequency, micrometres) in [(5.0, 59.0), (50.0, 4.3), (200.0, 0.43), (400.0, 0.22)] {
        assert!(is_near(afferents.threshold_at(frequency) * 1e6, micrometres), "{frequency} Hz");
    }
}

#[test]
fn a_file_of_thresholds_equals_the_same_known_curve() {
    let folder = tempfile::tempdir().unwrap();
    let hand = known(Threshold::Hand);
    let rows = HAND.map(|[f, _]| format!("{f}; {:e}\n", hand.threshold_at(f)));
    let text = format!("# mine\nfrequency; displacement\n{}", rows.concat());
    fs::write(folder.path().join("mine.csv"), text).unwrap();
    let scene = "format = 1\n[skin]\nthreshold = \"mine.csv\"\n";
    let path = folder.path().join("a.toml");
    let opened = opening::parse(scene, &path).unwrap();
    let skin = opened.skin.as_ref().unwrap();
    for frequency in [8.0, 14.0, 20.0, 44.7, 90.0, 250.0, 300.0, 315.0] {
        let (own, known) = (skin.threshold_at(frequency), hand.threshold_at(frequency));
        assert!((own / known - 1.0).abs() < 1e-12, "{frequency} Hz: {own} and {known}");
    }
    for beyond in [7.9, 315.1] {
        assert!([skin, &hand].iter().all(|skin| skin.threshold_at(beyond).is_infinite()), "{beyond} Hz");
    }
    // Straight in logarithms.
    let [low, middle, high] = [10.0, 10f64 * 1.25f64.sqrt(), 12.5].map(|f| skin.threshold_at(f));
    assert!((middle / (low * high).sqrt() - 1.0).abs() < 1e-12);
    // Saved elsewhere, it still finds its file, and its text has no numbers of it.
    let other = tempfile::tempdir().unwrap();
    let saved = other.path().join("b.toml");
    let placed = Paintings::default().place(&opened, &saved, |_| false).scene;
    let text = sonoglyph::scene::file::write(&placed);
    assert!(text.contains("mine.csv") && !text.contains("frequency = 250"), "{text}");
    let again = opening::parse(&text, &saved).unwrap();
    assert_eq!(again.skin.unwrap().curve.get(), skin.curve.get());
    assert!(Threshold::VARIANTS.iter().all(|&curve| !known(curve).lacks_curve()));
}

#[test]
fn invalid_thresholds_name_file_line_and_value() {
    let folder = tempfile::tempdir().unwrap();
    let head = "frequency,displacement\n";
    for (table, error) in [
        (format!("{head}20,1e-6\n20,2e-6\n"), "t.csv:3: frequency = 20: must be more than 20 Hz"),
        (format!("{head}0,1e-6\n20,2e-6\n"), "t.csv:2: frequency = 0: must be from 0.001 to"),
        (format!("{head}20,1e-6\n30,-1e-6\n"), "t.csv:3: displacement = -0.000001: must be metres (peak)"),
        (format!("{head}20,13.4\n30,4\n"), "t.csv:2: displacement = 13.4: must be metres (peak)"),
        (format!("{head}20,1e-6\n"), "t.csv:2: rows = 1: a curve has at least two"),
        (format!("{head}20,one\n"), "t.csv:2: displacement = `one`: not a finite number"),
        ("frequency\n20\n".to_owned(), "t.csv:1: the column `displacement` is missing"),
    ] {
        fs::write(folder.path().join("t.csv"), &table).unwrap();
        let scene = "format = 1\n[skin]\nthreshold = \"t.csv\"\n";
        let refused = opening::parse(scene, &folder.path().join("a.toml")).unwrap_err().to_string();
        assert!(refused.contains(error) && refused.contains("a.toml:3: skin.threshold"), "{refused}");
    }
    let refused = |scene: &str| opening::parse(scene, Path::new("a.toml")).unwrap_err().to_string();
    let missing = refused("format = 1\n[skin]\nthreshold = \"hnad\"\n");
    let parts = ["a.toml:3:", "unknown threshold: hand, psychohaptic, afferents", "hnad: no such file"];
    assert!(parts.iter().all(|part| missing.contains(part)), "{missing}");
    let empty = refused("format = 1\n[skin]\nthreshold = \"\"\n");
    assert!(empty.contains("a.toml:3:") && empty.contains("hand, psychohaptic, afferents"), "{empty}");
}

/// What is felt of a scene of these tables, with a focus in the middle.
fn felt(tables: &str) -> Felt {
    let text = format!("format = 1\n[[target]]\n[solver]\nmethod = \"focus\"\n[skin]\n{tables}");
    let scene = opening::parse(&text, Path::new("a.toml")).unwrap();
    Felt::of_solution(&scene, &solver::solve(&scene).unwrap()).unwrap()
}

/// The references are a model's in NumPy: the round mean of the focus' radiation pressure, a Hankel transform per line, and the sum
/// over the disc.
#[test]
fn a_modulated_focus_is_felt_as_a_model_says() {
    for (frequency, vibration) in [(80.0, 21.09), (120.0, 27.18), (200.0, 31.48)] {
        let felt = felt(&format!("[modulation]\nshape = \"sine\"\nfrequency = {frequency}\n"));
        assert!((felt.vibration - vibration).abs() < 0.5, "{frequency} Hz: {felt:?}");
        assert_eq!((felt.level, felt.pressure, felt.flutter), (felt.vibration, FLOOR, FLOOR));
        assert!(felt.position.unwrap().distance([0.0, 0.0, 0.1].into()) < 2e-4, "{felt:?}");
        assert_eq!((felt.strokes.len(), felt.share, felt.speeds), (0, None, None));
    }
    // Slow ones are felt where they are strongest.
    let slow = felt("[modulation]\nshape = \"sine\"\nfrequency = 20\n");
    assert!((slow.flutter + 9.65).abs() < 0.5 && slow.level == slow.flutter, "{slow:?}");
    let steady = felt("");
    assert_eq!((steady.level, steady.position), (FLOOR, None));
}

#[test]
fn a_circling_focus_is_felt_as_a_model_says() {
    // Radius in m, circles per second, dB of vibration, and on the circle of all lines.
    for (radius, rate, vibration, ring) in [
        (0.004, 80.0, 24.88, 25.90),
        (0.004, 200.0, 34.91, 35.14),
        (0.008, 120.0, 36.67, 33.87),
        (0.02, 7.0 / (0.04 * PI), 38.40, 31.50),
    ] {
        let felt = felt(&format!("[motion]\npath = \"circle\"\nsize = {}\nrate = {rate}\n", 2.0 * radius));
        assert!((felt.vibration - vibration).abs() < 0.5, "{radius} m, {rate} Hz: {felt:?}");
        let [stroke] = felt.strokes[..] else { panic!("{felt:?}") };
        assert!(stroke.target == 0 && (stroke.level - ring).abs() < 0.5, "{radius} m, {rate} Hz: {felt:?}");
        assert_eq!(felt.share, Some(1.0));
        // By Graf's series it is 8 m/s for 10 mm, and 7.5 to 8 m/s for 20 mm.
        let speeds = felt.speeds.unwrap();
        assert!((speeds.own - 2.0 * PI * radius * rate).abs() < 1e-9, "{speeds:?}");
        assert!((7.5..8.1).contains(&speeds.best), "{radius} m: {speeds:?}");
    }
}
