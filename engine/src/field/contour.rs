//! Contour lines, by marching squares.

use rayon::prelude::*;

/// Points in pixels from the lower left corner of the map: the first pixel's centre is at (0.5, 0.5). Closed lines
/// end with their first point.
pub type Line = Vec<[f32; 2]>;

/// Smallest distance between points of a line, in pixels.
const STEP: f32 = 2.0;
/// Squares skipped together if no line crosses them.
const RUN: usize = 64;

/// The sides of a square between four pixels.
const BELOW: u8 = 0;
const RIGHT: u8 = 1;
const ABOVE: u8 = 2;
const LEFT: u8 = 3;

/// The contour lines at `level` of pixels in rows of `width`, the first at the bottom. Larger values are on their
/// left. Lines end at pixels that are no numbers.
pub fn lines<P: Sync>(
    pixels: &[P],
    width: usize,
    level: f32,
    number: impl Fn(&P) -> f32 + Sync,
) -> Vec<Line> {
    let height = pixels.len().checked_div(width).unwrap_or(0);
    if width < 2 || height < 2 {
        return Vec::new();
    }
    let mut reaches = vec![0; width * height];
    reaches.par_chunks_mut(width).zip(pixels.par_chunks(width)).with_min_len(16).for_each(
        |(reaches, pixels)| {
            for (reaches, pixel) in reaches.iter_mut().zip(pixels) {
                *reaches = u8::from(number(pixel) >= level);
            }
        },
    );
    let number = |pixel: usize| number(&pixels[pixel]);
    Squares { width, height, level, number, reaches, passed: vec![0; width * height] }.lines()
}

/// The squares between pixel centres, one per pixel except in the last row and column.
struct Squares<N> {
    width: usize,
    height: usize,
    level: f32,
    number: N,
    /// 1 if a pixel reaches the level.
    reaches: Vec<u8>,
    /// The sides already entered by lines, a bit each.
    passed: Vec<u8>,
}

impl<N: Fn(usize) -> f32> Squares<N> {
    fn lines(mut self) -> Vec<Line> {
        let (across, up) = (self.width - 1, self.height - 1);
        let mut lines = Vec::new();
        // Lines from the edge first, since they have ends.
        for x in 0..across {
            self.start(&mut lines, (x, 0), BELOW);
            self.start(&mut lines, (x, up - 1), ABOVE);
        }
        for y in 0..up {
            self.start(&mut lines, (0, y), LEFT);
            self.start(&mut lines, (across - 1, y), RIGHT);
        }
        for y in 0..up {
            for first in (0..across).step_by(RUN) {
                let run = first..(first + RUN).min(across);
                if self.is_even(run.clone(), y) {
                    continue;
                }
                for x in run {
                    if self.is_even(x..x + 1, y) {
                        continue;
                    }
                    for side in [BELOW, RIGHT, ABOVE, LEFT] {
                        self.start(&mut lines, (x, y), side);
                    }
                }
            }
        }
        lines
    }

    /// Whether all corners of squares in a row are on the same side of the level.
    fn is_even(&self, squares: std::ops::Range<usize>, y: usize) -> bool {
        let corners = |row: usize| &self.reaches[row * self.width..][squares.start..=squares.end];
        let (below, above) = (corners(y), corners(y + 1));
        let like_the_first = &[[0; RUN + 1], [1; RUN + 1]][usize::from(below[0])][..below.len()];
        below == like_the_first && above == like_the_first
    }

    /// Follows the line that enters a square through this side, if any, and not followed before.
    fn start(&mut self, lines: &mut Vec<Line>, (mut x, mut y): (usize, usize), mut side: u8) {
        let (mut line, begun) = (Line::new(), ((x, y), side));
        while let Some(out) = self.way((x, y), side) {
            let passed = &mut self.passed[y * self.width + x];
            if *passed & 1 << side != 0 {
                break;
            }
            *passed |= 1 << side;
            let place = self.crossing((x, y), side);
            let is_far = |&[u, v]: &[f32; 2]| {
                let (u, v) = (place[0] - u, place[1] - v);
                u * u + v * v >= STEP * STEP
            };
            if line.last().is_none_or(is_far) {
                line.push(place);
            }
            let is_last = match out {
                BELOW => y == 0,
                RIGHT => x + 2 == self.width,
                ABOVE => y + 2 == self.height,
                _ => x == 0,
            };
            if is_last {
                line.push(self.crossing((x, y), out));
                lines.push(line);
                return;
            }
            match out {
                BELOW => y -= 1,
                RIGHT => x += 1,
                ABOVE => y += 1,
                _ => x -= 1,
            }
            side = (out + 2) % 4;
        }
        let Some(&first) = line.first() else { return };
        if ((x, y), side) == begun {
            if line.len() > 2 {
                line.push(first);
                lines.push(line);
            }
        } else {
            // At a pixel without a number, or where the rest of a line that ends at one begins.
            line.push(self.crossing((x, y), side));
            lines.push(line);
        }
    }

    /// The side through which a line leaves a square after entering through `side`.
    fn way(&self, (x, y): (usize, usize), side: u8) -> Option<u8> {
        let at = y * self.width + x;
        let corners = [at, at + 1, at + self.width + 1, at + self.width];
        let bits = |bits, (i, &corner): (usize, &usize)| bits | self.reaches[corner] << i;
        let corners_that_reach = corners.iter().enumerate().fold(0u8, bits);
        let is_mixed = !matches!(corners_that_reach, 0 | 15);
        if is_mixed && corners.iter().any(|&corner| (self.number)(corner).is_nan()) {
            return None;
        }
        let is_joined = || {
            let mean = corners.iter().map(|&corner| (self.number)(corner)).sum::<f32>() / 4.0;
            mean >= self.level
        };
        let ways: &[[u8; 2]] = match corners_that_reach {
            1 => &[[BELOW, LEFT]],
            2 => &[[RIGHT, BELOW]],
            3 => &[[RIGHT, LEFT]],
            4 => &[[ABOVE, RIGHT]],
            5 if is_joined() => &[[ABOVE, LEFT], [BELOW, RIGHT]],
            5 => &[[BELOW, LEFT], [ABOVE, RIGHT]],
            6 => &[[ABOVE, BELOW]],
            7 => &[[ABOVE, LEFT]],
            8 => &[[LEFT, ABOVE]],
            9 => &[[BELOW, ABOVE]],
            10 if is_joined() => &[[LEFT, BELOW], [RIGHT, ABOVE]],
            10 => &[[RIGHT, BELOW], [LEFT, ABOVE]],
            11 => &[[RIGHT, ABOVE]],
            12 => &[[LEFT, RIGHT]],
            13 => &[[BELOW, RIGHT]],
            14 => &[[LEFT, BELOW]],
            _ => &[],
        };
        ways.iter().find(|[enters, _]| *enters == side).map(|[_, leaves]| *leaves)
    }

    /// The crossing of the level on a side of a square, by linear interpolation between its two pixels.
    fn crossing(&self, (x, y): (usize, usize), side: u8) -> [f32; 2] {
        let (from, to) = match side {
            BELOW => ((x, y), (x + 1, y)),
            RIGHT => ((x + 1, y), (x + 1, y + 1)),
            ABOVE => ((x, y + 1), (x + 1, y + 1)),
            _ => ((x, y), (x, y + 1)),
        };
        let number = |(x, y): (usize, usize)| (self.number)(y * self.width + x);
        let part = ((self.level - number(from)) / (number(to) - number(from))).clamp(0.0, 1.0);
        let between = |from: usize, to: usize| from as f32 + 0.5 + part * (to as f32 - from as f32);
        [between(from.0, to.0), between(from.1, to.1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 90;
    const HEIGHT: usize = 70;

    fn at(i: usize) -> (f32, f32) {
        ((i % WIDTH) as f32 + 0.5, (i / WIDTH) as f32 + 0.5)
    }

    fn of(level: f32, number: impl Fn(usize) -> f32) -> Vec<Line> {
        let numbers: Vec<f32> = (0..WIDTH * HEIGHT).map(number).collect();
        lines(&numbers, WIDTH, level, |&number| number)
    }

    fn area(line: &Line) -> f32 {
        line.windows(2).map(|pair| (pair[0][0] * pair[1][1] - pair[1][0] * pair[0][1]) / 2.0).sum()
    }

    #[test]
    fn lines_end_at_pixels_without_numbers() {
        let hill = |i| 40.0 - (at(i).0 - 41.3).hypot(at(i).1 - 30.8);
        let is_hole = |i: usize| (at(i).0 - 61.0).abs() < 5.0 && (at(i).1 - 33.0).abs() < 4.0;
        let found = of(20.0, |i| if is_hole(i) { f32::NAN } else { hill(i) });
        let far = |[x, y]: &[f32; 2]| ((x - 41.3).hypot(y - 30.8) - 20.0).abs();
        assert!(found.iter().flatten().all(|place| far(place) < 0.02), "{found:?}");
        let length = |[a, b]: &[[f32; 2]; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let pairs = || found.iter().flat_map(|line| line.windows(2)).map(|pair| [pair[0], pair[1]]);
        assert!(pairs().all(|pair| length(&pair) < 4.0), "{found:?}");
        // All of the circle but what is near the hole, about 8 of 126.
        let sum: f32 = pairs().map(|pair| length(&pair)).sum();
        assert!((110.0..119.0).contains(&sum), "{sum}");
    }

    #[test]
    fn a_hill_is_a_circle_run_round_counter_clockwise() {
        let hill = |i| 40.0 - (at(i).0 - 41.3).hypot(at(i).1 - 30.8);
        let found = of(20.0, hill);
        let [line] = &found[..] else { panic!("{} lines", found.len()) };
        assert_eq!(line.first(), line.last());
        assert!(line.iter().all(|[x, y]| ((x - 41.3).hypot(y - 30.8) - 20.0).abs() < 0.02), "{line:?}");
        assert!((area(line) / (std::f32::consts::PI * 400.0) - 1.0).abs() < 0.01, "{}", area(line));
        // A bar one pixel high.
        let bar = of(0.5, |i| if i / WIDTH == 33 && (30..60).contains(&(i % WIDTH)) { 1.0 } else { 0.0 });
        assert_eq!((bar.len(), bar[0].first()), (1, bar[0].last()));
        let hole = of(-20.0, |i| -hill(i));
        assert!(area(&hole[0]) < 0.0 && hole.len() == 1);
    }

    #[test]
    fn pixels_at_the_level_are_within_its_lines() {
        let is_in = |i: usize| (20..30).contains(&(i % WIDTH)) && (10..40).contains(&(i / WIDTH));
        let found = of(1.0, |i| if is_in(i) { 1.0 } else { 0.0 });
        let [line] = &found[..] else { panic!("{} lines", found.len()) };
        // Around the centres of the outermost pixels, with corners cut off.
        assert!(line.first() == line.last() && (area(line) - 9.0 * 29.0).abs() < 8.0, "{}", area(line));
    }

    #[test]
    fn areas_that_touch_at_a_corner_are_one_if_their_mean_there_reaches_the_level() {
        for slope in [1, -1] {
            let is_in = |i: usize| {
                let (x, y) = ((i % WIDTH) as i32 - 40, slope * ((i / WIDTH) as i32 - 30));
                [0..5, -5..0].into_iter().any(|range| range.contains(&x) && range.contains(&y))
            };
            let counts = [0.4, 0.5, 0.6].map(|level| of(level, |i| if is_in(i) { 1.0 } else { 0.0 }).len());
            assert_eq!(counts, [1, 1, 2], "{slope}");
        }
    }

    #[test]
    fn lines_end_at_the_edge_and_nowhere_else() {
        // A saddle, whose lines all cross the edge.
        let saddle = |i| (at(i).0 - 45.0) * (at(i).1 - 35.0);
        for level in [-200.0, -0.1, 0.0, 0.1, 200.0] {
            let lines = of(level, saddle);
            assert_eq!(lines.len(), 2, "{level}");
            let on_edge = |&[x, y]: &[f32; 2]| {
                [0.5, WIDTH as f32 - 0.5].contains(&x) || [0.5, HEIGHT as f32 - 0.5].contains(&y)
            };
            assert!(lines.iter().all(|line| on_edge(&line[0]) && on_edge(line.last().unwrap())), "{level}");
        }
        // Half a hill on each edge: both ends of its line are on this edge.
        let (right, top) = (WIDTH as f32 - 0.5, HEIGHT as f32 - 0.5);
        for (x, y) in [(0.5, 35.0), (right, 35.0), (45.0, 0.5), (45.0, top)] {
            for sign in [1.0, -1.0] {
                let found = of(sign * 20.0, |i| sign * (40.0 - (at(i).0 - x).hypot(at(i).1 - y)));
                let [line] = &found[..] else { panic!("{x}, {y}: {} lines", found.len()) };
                for end in [line[0], line[line.len() - 1]] {
                    assert!(end[0] == x || end[1] == y, "{x}, {y}: {end:?}");
                }
            }
        }
    }

    #[test]
    fn what_has_no_lines_has_none_and_noise_does_no_harm() {
        assert!(of(1.0, |_| 0.0).is_empty());
        assert!(of(0.5, |_| f32::NAN).is_empty());
        assert!(lines(&[], 0, 1.0, |_: &f32| 2.0).is_empty());
        assert!(lines(&[0.0, 2.0], 2, 1.0, |&value| value).is_empty());
        let noise = |i: usize| (i.wrapping_mul(2_654_435_761) >> 7) as f32 % 100.0;
        let lines = of(50.0, noise);
        assert!(lines.len() > 100 && lines.iter().flatten().flatten().all(|place| place.is_finite()));
    }
}
