//! Invalid numbers in imported drawings.

use glam::{DVec2, DVec3};

use sonoglyph::import::{self, Line, Placement};
use sonoglyph::scene::Sampling;

use crate::poison::{POISON, SIZES};

#[test]
fn simplification_of_any_line_terminates() {
    for poison in POISON {
        for closed in [false, true] {
            let points = vec![DVec2::ZERO, DVec2::new(poison, 1.0), DVec2::new(1.0, -poison), DVec2::ONE];
            let line = Line::new(points, closed);
            for tolerance in POISON {
                assert!(line.simplified(tolerance).points.len() <= 4);
                for most in [0, 1, 2, 3, usize::MAX] {
                    assert!(
                        line.with_at_most(most, tolerance).points.len() <= most.max(2),
                        "{poison} {tolerance}"
                    );
                }
                line.without_beginning(tolerance);
            }
            line.distance(DVec2::splat(poison));
        }
    }
    let dot = Line::new(vec![DVec2::ONE], true);
    assert_eq!((dot.length(), dot.simplified(0.1).points.len()), (0.0, 1));
}

#[test]
fn drawings_are_placed_or_refused() {
    let svg = b"<svg xmlns='http://www.w3.org/2000/svg' width='9' height='9'><path d='M0 0h9v5' fill='none' stroke='red'/></svg>";
    let drawing = import::read(svg).unwrap();
    let place = |side, sampling| Placement { at: DVec3::Z * 0.1, x: DVec3::X, y: DVec3::Y, side, sampling };
    for poison in POISON {
        for placement in [place(poison, Sampling::Spacing(0.01)), place(0.1, Sampling::Spacing(poison))] {
            let targets = placement.targets(&drawing);
            assert!(targets.is_err() || targets.is_ok_and(|targets| targets.len() <= 1024), "{poison}");
        }
    }
    for points in SIZES {
        let targets = place(0.1, Sampling::Points(points)).targets(&drawing);
        assert!(targets.is_err() || targets.is_ok_and(|targets| targets.len() <= 1024), "{points}");
    }
    for bytes in [&b""[..], b"\x89PNG\r\n\x1a\n", b"<svg", b"BM", &[0xFF; 64]] {
        assert!(import::read(bytes).is_err());
    }
}
