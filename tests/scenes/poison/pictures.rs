//! Invalid numbers in pictures, numeric files, animations, charts and shaded surfaces.

use glam::DVec2;
use sonoglyph::picture::animation::{Animation, AnimationError, Colours, Format, Pace};
use sonoglyph::picture::chart::{Chart, Level, Series};
use sonoglyph::picture::relief::{self, Relief, Words};
use sonoglyph::picture::{ColourMap, Picture, export, numbers, sheet};
use sonoglyph::rounding;
use sonoglyph::scene::Plane;

use crate::poison::{POISON, SIZES, panics};

#[test]
fn pictures_have_four_bytes_a_pixel() {
    assert!(panics(|| Picture::from_field_order(2, 2, &[0; 15])));
    let nothing = Picture::from_field_order(0, 3, &[]);
    assert!(panics(|| nothing.pixel(0, 0)));
    assert!(panics(|| export::png(&Picture { width: 3, height: 3, rgba: vec![0; 8] })));
    for shape in [&[2u64, 2][..], &[0], &[u64::MAX, 3]] {
        assert!(
            panics(|| numbers::npy(shape, &[1.0; 5]).is_err()) || numbers::npy(shape, &[1.0; 5]).is_err(),
            "{shape:?}"
        );
    }
    let bytes = numbers::npy(&[2], &[f32::NAN, f32::INFINITY]).unwrap();
    assert!(bytes.ends_with(&f32::INFINITY.to_le_bytes()), "numbers are written unchanged");
}

#[test]
fn animations_have_frames_and_sides() {
    let colours = Colours::Map(Box::new(ColourMap::Grey.table()));
    for pace in POISON.map(Pace::new) {
        assert!((0.02..=60.0).contains(&pace.per_frame) && pace.slowed >= 0.0, "{pace:?}");
    }
    for format in [Format::Gif, Format::Png] {
        let begun = |size, frames| Animation::new(Vec::new(), format, size, &colours, frames, Pace::new(5.0));
        for side in SIZES {
            for size in [(side, 2), (2, side)] {
                assert!(matches!(begun(size, 1), Err(AnimationError::Size { .. })), "{format:?} {size:?}");
            }
        }
        assert!(matches!(begun((2, 2), 0), Err(AnimationError::Size { .. })));
        let mut animation = begun((2, 2), 1).unwrap();
        let other = Picture { width: 5, height: 1, rgba: vec![0; 20] };
        assert!(panics(|| animation.add(&other)));
    }
}

#[test]
fn charts_leave_out_values_without_a_logarithm() {
    let chart = |points: Vec<(f64, f64)>| Chart {
        title: "poison".to_owned(),
        x_label: "x".to_owned(),
        y_label: "y".to_owned(),
        series: vec![Series { name: "a".to_owned(), points }],
        levels: POISON.map(|y| Level { name: "b".to_owned(), y }).to_vec(),
    };
    assert!(chart(Vec::new()).draw().is_err());
    for poison in POISON.into_iter().filter(|x| !x.is_finite() || *x <= 0.0) {
        assert!(chart(vec![(poison, 1.0), (1.0, poison)]).draw().is_err(), "{poison}");
        assert!(chart(vec![(poison, 1.0), (1.0, 2.0)]).draw().is_ok(), "{poison}");
    }
    let all = POISON.iter().flat_map(|&x| POISON.map(|y| (x, y))).collect();
    assert!(!panics(|| chart(all).draw().is_ok()));
}

#[test]
fn reliefs_of_any_numbers_are_pictures() {
    for poison in POISON {
        let mut depth = vec![1e-5f32; 12];
        depth[5] = poison as f32;
        let relief = Relief::new(&depth, 4, DVec2::new(0.04, 0.03));
        assert!((1.0..=1e6).contains(&relief.exaggeration), "{poison}");
        let picture = relief.page(Words::default(), (90, 60));
        assert_eq!(picture.rgba.len(), 90 * 60 * 4, "{poison}");
    }
    assert!(relief::height(0) == 0 && sheet::height(0) == 0 && sheet::drive_height(0) == 0);
}

#[test]
fn sizes_of_pages_are_bounded() {
    for poison in POISON {
        let plane = Plane { size: DVec2::new(poison, 0.1), ..Plane::default() };
        let (width, height) = sheet::map_size(&plane, 1600, 1000);
        assert!(width <= 1600 && height <= 1000, "{poison}: {width} x {height}");
        assert!(!rounding::pascals(poison).is_empty());
    }
}
