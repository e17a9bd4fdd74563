//! G-code of plotters, lasers and tools: lines (G0, G1) and arcs (G2, G3) in the array's axes.
//!
//! Units are millimetres (G21) or inches (G20), places absolute (G90) or relative (G91), arc centres relative to their
//! start (G91.1) or absolute (G90.1), arcs in the XY plane (G17), helices included. F is the feed in units per minute.
//! G92 names the current place anew, and G28 and G30 go to an unknown one.
//!
//! Only drawn moves are traced; the others are jumps. Drawn are G1, G2 and G3 while the pen is down:
//!
//! 1. with M3 or M4 and M5 in the program, from M3 or M4 to M5, unless the power is S0;
//! 2. otherwise with E words, where filament is pushed;
//! 3. otherwise, where the tool moves sideways at two heights and changes between them only straight up and down, at
//!    the lower one.
//!
//! A program of G0 alone is traced as a whole. The heights of a pen, or of a program at z = 0 or below, are not those of
//! targets, which then keep their own.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::echo;
use crate::scene::motion::{Trace, TracePlace};
use crate::studio::routes::limits::{FARTHEST, MOST_PLACES, Traced};
use crate::table::TableError;

/// m, in units of a program.
const MILLIMETRE: f64 = 1e-3;
const INCH: f64 = 0.0254;
/// Largest distance of an arc from its chords, m.
const TOLERANCE: f64 = 1e-6;
/// Limit of the numbers of words.
const LARGEST: f64 = 1e9;
/// Limit of the codes that a remark lists.
const MOST_LISTED: usize = 12;
/// Difference of an arc's radii at its ends that is refused, m, and in parts of the radius: those of Grbl.
const ECCENTRIC: (f64, f64, f64) = (5e-4, 5e-6, 1e-3);
/// m: heights closer than this are the same.
const LEVEL: f64 = 1e-6;
/// Codes that change nothing here: planes, offsets and modes that are the usual ones, and ends and coolant.
const SILENT_G: [f64; 12] = [17.0, 40.0, 49.0, 50.0, 54.0, 61.0, 64.0, 80.0, 94.0, 97.0, 98.0, 4.0];
const SILENT_M: [f64; 9] = [0.0, 1.0, 6.0, 7.0, 8.0, 9.0, 82.0, 84.0, 17.0];

/// Whether a text is a program: its first line with words begins with a code.
pub(super) fn is_program(text: &str) -> bool {
    let words = text.lines().map(|line| bare(line).unwrap_or_default()).find(|line| !line.is_empty());
    let mut letters = words.as_deref().unwrap_or("").chars();
    letters.next().is_some_and(|letter| "GMNTF".contains(letter))
        && letters.next().is_some_and(|digit| digit.is_ascii_digit())
}

/// The trace of a program.
pub(super) fn read(text: &str) -> Result<Traced, TableError> {
    let mut machine = Machine::default();
    for (index, line) in text.lines().enumerate() {
        if machine.has_ended {
            break;
        }
        let line_number = index as u64 + 1;
        machine.line(line).map_err(|reason| TableError { line: line_number, reason })?;
        if machine.moves.len() > MOST_PLACES {
            let reason = format!("more than the {MOST_PLACES} places of a path");
            return Err(TableError { line: line_number, reason });
        }
    }
    let trace = machine.trace();
    if trace.places.is_empty() {
        return Err(TableError { line: 1, reason: "there are no moves in it".to_owned() });
    }
    Ok((vec![trace], machine.remarks()))
}

/// A line in capitals, without comments, blanks, checksum and line number.
fn bare(line: &str) -> Result<String, String> {
    let (mut bare, mut depth) = (String::new(), 0);
    for letter in line.chars() {
        match letter {
            ';' | '*' if depth == 0 => break,
            '(' => depth += 1,
            ')' if depth > 0 => depth -= 1,
            _ if depth > 0 || letter.is_whitespace() || letter == '%' => {}
            _ => bare.extend(letter.to_uppercase()),
        }
    }
    if depth > 0 {
        return Err("a comment is not closed".to_owned());
    }
    let rest = bare.strip_prefix('/').unwrap_or(&bare);
    let Some(numbered) = rest.strip_prefix('N') else { return Ok(rest.to_owned()) };
    Ok(numbered.trim_start_matches(|digit: char| digit.is_ascii_digit()).to_owned())
}

/// The words of a line: letters with their numbers.
fn words(line: &str) -> Result<Vec<(char, f64)>, String> {
    if line.starts_with('O') || line.contains(['#', '[', ']', '=', '<', '>']) {
        return Err(format!("`{}`: variables and expressions are not read", echo::value(line)));
    }
    let mut words = Vec::new();
    let mut rest = line;
    while let Some(letter) = rest.chars().next() {
        let value = &rest[letter.len_utf8()..];
        let end = value.find(|part: char| !(part.is_ascii_digit() || "+-.".contains(part)));
        let (number, next) = value.split_at(end.unwrap_or(value.len()));
        let is_word = |number: &f64| letter.is_ascii_alphabetic() && number.abs() <= LARGEST;
        let Some(number) = number.parse::<f64>().ok().filter(is_word) else {
            return Err(format!("`{}`: not a word of G-code", echo::value(rest)));
        };
        words.push((letter, number));
        rest = next;
    }
    Ok(words)
}

/// A straight move.
#[derive(Clone, Copy, Debug)]
struct Move {
    from: DVec3,
    to: DVec3,
    is_feed: bool,
    /// m/s
    feed: Option<f64>,
    /// The state of a spindle or laser, and whether filament was pushed.
    is_on: bool,
    pushes: bool,
}

impl Move {
    fn is_sideways(&self) -> bool {
        self.from.truncate() != self.to.truncate()
    }
}

/// The modal motion.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Rapid,
    Line,
    Arc {
        is_clockwise: bool,
    },
    /// Cancelled, or of an unknown code.
    None,
}

/// The state of a machine, and its moves.
struct Machine {
    unit: f64,
    is_relative: bool,
    has_absolute_centres: bool,
    mode: Mode,
    /// m/s
    feed: Option<f64>,
    /// m; of unknown coordinates, 0.
    at: DVec3,
    /// m, added to coordinates.
    shift: DVec3,
    is_known: bool,
    has_moved: bool,
    extruded: f64,
    extrudes_relative: bool,
    is_on: bool,
    power: f64,
    switches: bool,
    extrudes: bool,
    has_ended: bool,
    moves: Vec<Move>,
    left_out: BTreeSet<String>,
}

impl Default for Machine {
    fn default() -> Self {
        Self {
            unit: MILLIMETRE,
            is_relative: false,
            has_absolute_centres: false,
            mode: Mode::None,
            feed: None,
            at: DVec3::ZERO,
            shift: DVec3::ZERO,
            is_known: false,
            has_moved: false,
            extruded: 0.0,
            extrudes_relative: false,
            is_on: false,
            power: 1.0,
            switches: false,
            extrudes: false,
            has_ended: false,
            moves: Vec::new(),
            left_out: BTreeSet::new(),
        }
    }
}

impl Machine {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let words = words(&bare(line)?)?;
        let has_axes = words.iter().any(|(letter, _)| "XYZ".contains(*letter));
        let value = |letter: char| words.iter().find(|(own, _)| *own == letter).map(|(_, value)| *value);
        let (mut names_place, mut goes_home) = (false, false);
        for &(_, code) in words.iter().filter(|(letter, _)| *letter == 'G') {
            match code {
                0.0 => self.mode = Mode::Rapid,
                1.0 => self.mode = Mode::Line,
                2.0 | 3.0 => self.mode = Mode::Arc { is_clockwise: code == 2.0 },
                20.0 => self.unit = INCH,
                21.0 => self.unit = MILLIMETRE,
                90.0 => self.is_relative = false,
                91.0 => self.is_relative = true,
                90.1 => self.has_absolute_centres = true,
                91.1 => self.has_absolute_centres = false,
                92.0 => names_place = true,
                28.0 | 30.0 => goes_home = true,
                18.0 | 19.0 => return Err(format!("G{code}: only arcs in the XY plane (G17) are read")),
                93.0 => return Err("G93: only feeds in units per minute (G94) are read".to_owned()),
                _ if SILENT_G.contains(&code) => {}
                _ if has_axes => {
                    return Err(format!("G{code} is not read: only lines (G0, G1) and arcs (G2, G3) are"));
                }
                _ => drop(self.left_out.insert(format!("G{code}"))),
            }
        }
        for &(_, code) in words.iter().filter(|(letter, _)| *letter == 'M') {
            match code {
                2.0 | 30.0 => self.has_ended = true,
                3.0 | 4.0 => (self.is_on, self.switches) = (true, true),
                5.0 => (self.is_on, self.switches) = (false, true),
                83.0 => self.extrudes_relative = true,
                82.0 => self.extrudes_relative = false,
                _ if SILENT_M.contains(&code) => {}
                _ => drop(self.left_out.insert(format!("M{code}"))),
            }
        }
        for (letter, _) in words.iter().filter(|(letter, _)| !"GMXYZIJKRFSEPTNHDL".contains(*letter)) {
            self.left_out.insert(format!("words with {letter}"));
        }
        if let Some(feed) = value('F').filter(|_| !goes_home) {
            self.feed = Some(feed * self.unit / 60.0).filter(|feed| *feed > 0.0);
        }
        if let Some(power) = value('S') {
            self.power = power;
        }
        let given = ['X', 'Y', 'Z'].map(|axis| value(axis).map(|value| value * self.unit));
        if names_place {
            self.name_place(given, value('E'));
        } else if goes_home {
            self.is_known = false;
        } else if has_axes || (words.iter().any(|(letter, _)| "IJ".contains(*letter))) {
            self.go(given, value)?;
        } else if let Some(extruded) = value('E') {
            self.extruded = if self.extrudes_relative || self.is_relative { 0.0 } else { extruded };
        }
        Ok(())
    }

    /// The current place by another name: before any move without effect on the moves that follow.
    fn name_place(&mut self, given: [Option<f64>; 3], extruded: Option<f64>) {
        self.extruded = extruded.unwrap_or(self.extruded);
        for (axis, given) in given.into_iter().enumerate() {
            let Some(given) = given else { continue };
            if self.has_moved {
                self.shift[axis] = self.at[axis] - given;
            } else {
                self.at[axis] = given;
            }
        }
    }

    fn go(&mut self, given: [Option<f64>; 3], value: impl Fn(char) -> Option<f64>) -> Result<(), String> {
        let mut to = self.at;
        for (axis, given) in given.into_iter().enumerate() {
            let Some(given) = given else { continue };
            to[axis] = if self.is_relative { self.at[axis] + given } else { given + self.shift[axis] };
        }
        if to.abs().to_array().iter().any(|part| *part > FARTHEST) {
            let [x, y, z] = (to / MILLIMETRE).to_array();
            return Err(format!("({x}, {y}, {z}) mm is farther than {FARTHEST} m"));
        }
        let pushes = value('E').is_some_and(|extruded| {
            let is_relative = self.extrudes_relative || self.is_relative;
            let pushed = if is_relative { extruded } else { extruded - self.extruded };
            self.extruded = if is_relative { 0.0 } else { extruded };
            pushed > 0.0
        });
        self.extrudes |= pushes;
        let from = self.at;
        (self.at, self.has_moved) = (to, true);
        let was_known = std::mem::replace(&mut self.is_known, true);
        let is_feed = match self.mode {
            Mode::None => return Err("a place without G0, G1, G2 or G3 before it".to_owned()),
            Mode::Rapid => false,
            Mode::Line | Mode::Arc { .. } => true,
        };
        let (feed, is_on) = (self.feed, self.is_on && self.power != 0.0);
        let own = Move { from, to, is_feed, feed, is_on, pushes };
        match self.mode {
            // From an unknown place nothing is drawn.
            _ if !was_known => self.moves.push(Move { from: to, ..own }),
            Mode::Arc { is_clockwise } => {
                let centre = self.centre((from, to), is_clockwise, &value)?;
                let turns = value('P').unwrap_or(1.0).max(1.0) - 1.0;
                let places = arc(from, to, centre, is_clockwise, turns.floor());
                let mut before = from;
                for place in places {
                    self.moves.push(Move { from: before, to: place, ..own });
                    before = place;
                }
            }
            Mode::Rapid | Mode::Line | Mode::None => self.moves.push(own),
        }
        Ok(())
    }

    /// The centre of an arc, m.
    fn centre(
        &self,
        (from, to): (DVec3, DVec3),
        is_clockwise: bool,
        value: &impl Fn(char) -> Option<f64>,
    ) -> Result<DVec2, String> {
        let (from, to) = (from.truncate(), to.truncate());
        let offset = ['I', 'J'].map(|axis| value(axis).map(|value| value * self.unit));
        if let Some(radius) = value('R').map(|radius| radius * self.unit) {
            within_reach(radius.abs())?;
            let half = (to - from) / 2.0;
            let height = radius * radius - half.length_squared();
            if half == DVec2::ZERO {
                return Err("R does not tell the centre of a full circle: give I and J".to_owned());
            }
            // Rounded half circles.
            if height < -ECCENTRIC.2 * radius * radius {
                let (radius, apart) = (radius.abs() / MILLIMETRE, 2.0 * half.length() / MILLIMETRE);
                return Err(format!(
                    "R = {radius:.3} mm is too short: the ends of the arc are {apart:.3} mm apart"
                ));
            }
            // The centre is left of a counter-clockwise arc of less than half a turn.
            let is_left = is_clockwise == (radius < 0.0);
            let across = half.perp().normalize_or_zero() * height.max(0.0).sqrt();
            return Ok(from + half + if is_left { across } else { -across });
        }
        let [Some(i), Some(j)] = offset.map(|given| given.or(offset[0].or(offset[1]).map(|_| 0.0))) else {
            return Err("an arc needs its centre, I and J, or its radius R".to_owned());
        };
        let centre = match self.has_absolute_centres {
            true => {
                let own = |given: Option<f64>, axis: usize| {
                    given.map_or(from[axis], |given| given + self.shift[axis])
                };
                DVec2::new(own(offset[0], 0), own(offset[1], 1))
            }
            false => from + DVec2::new(i, j),
        };
        let radii = [from, to].map(|end| end.distance(centre));
        within_reach(radii[0])?;
        let off = (radii[0] - radii[1]).abs();
        let (most, least, part) = ECCENTRIC;
        if radii[0] == 0.0 || off > most || (off > least && off > part * radii[0]) {
            let [a, b] = radii.map(|radius| radius / MILLIMETRE);
            return Err(format!("the ends of the arc are {a:.3} and {b:.3} mm from its centre"));
        }
        Ok(centre)
    }

    /// What was left aside.
    fn remarks(&self) -> Vec<String> {
        if self.left_out.is_empty() {
            return Vec::new();
        }
        let codes: Vec<_> = self.left_out.iter().map(String::as_str).take(MOST_LISTED).collect();
        let others = if self.left_out.len() > MOST_LISTED { " and others" } else { "" };
        vec![format!("left out, as they draw nothing here: {}{others}", codes.join(", "))]
    }

    fn trace(&self) -> Trace {
        let pen = self.pen();
        let is_drawn = |it: &Move| match pen {
            Pen::Switched => it.is_feed && it.is_on,
            Pen::Pushed => it.is_feed && it.pushes,
            Pen::Lowered(low) => {
                it.is_feed && (it.from.z - low).abs() < LEVEL && (it.to.z - low).abs() < LEVEL
            }
            Pen::Down => it.is_feed,
            Pen::Everywhere => true,
        };
        let drawn: Vec<_> = self.moves.iter().filter(|it| is_drawn(it)).collect();
        let has_feeds = drawn.iter().filter(|it| it.from != it.to).all(|it| it.feed.is_some());
        let (mut places, mut time): (Vec<TracePlace>, f64) = (Vec::new(), 0.0);
        for Move { from, to, feed, .. } in drawn {
            let jumps = places.last().is_none_or(|last| last.at != *from);
            if jumps {
                places.push(TracePlace {
                    at: *from,
                    time: has_feeds.then_some(time),
                    jumps: !places.is_empty(),
                });
            }
            if from != to {
                time += feed.map_or(0.0, |feed| from.distance(*to) / feed);
                places.push(TracePlace { at: *to, time: has_feeds.then_some(time), jumps: false });
            }
        }
        let first = places.first().map_or(0.0, |place| place.at.z);
        let is_flat = places.iter().all(|place| (place.at.z - first).abs() < LEVEL);
        let has_height = !(matches!(pen, Pen::Lowered(_)) || is_flat && first <= 0.0);
        Trace { target: None, places, has_height }
    }

    /// What tells drawn moves from others.
    fn pen(&self) -> Pen {
        if !self.moves.iter().any(|it| it.is_feed && it.from != it.to) {
            return Pen::Everywhere;
        }
        if self.switches {
            return Pen::Switched;
        }
        if self.extrudes {
            return Pen::Pushed;
        }
        let is_level = |it: &Move| (it.from.z - it.to.z).abs() < LEVEL;
        let mut levels: Vec<f64> = Vec::new();
        for it in self.moves.iter().filter(|it| it.is_sideways()) {
            if !is_level(it) {
                return Pen::Down;
            }
            if !levels.iter().any(|level| (level - it.to.z).abs() < LEVEL) {
                levels.push(it.to.z);
            }
        }
        match levels[..] {
            [a, b] => Pen::Lowered(a.min(b)),
            _ => Pen::Down,
        }
    }
}

/// Refuses an arc of a larger radius (m) than places are apart.
fn within_reach(radius: f64) -> Result<(), String> {
    if radius <= FARTHEST {
        return Ok(());
    }
    Err(format!("an arc of {} mm is larger than {FARTHEST} m", radius / MILLIMETRE))
}

/// What tells drawn moves from others.
#[derive(Clone, Copy, Debug)]
enum Pen {
    Switched,
    Pushed,
    /// At this height, m.
    Lowered(f64),
    /// In every feed.
    Down,
    /// In rapid moves, too.
    Everywhere,
}

/// The places of an arc after its start, with further full turns.
fn arc(from: DVec3, to: DVec3, centre: DVec2, is_clockwise: bool, turns: f64) -> Vec<DVec3> {
    let [start, end] = [from, to].map(|place| place.truncate() - centre);
    let sense = if is_clockwise { -1.0 } else { 1.0 };
    let swept = (sense * (end.to_angle() - start.to_angle())).rem_euclid(TAU);
    // Ends that are equal make a full circle.
    let is_full = start.distance(end) < 1e-9 || swept < 1e-9;
    let angle = sense * (if is_full { TAU } else { swept } + turns * TAU);
    let radius = start.length();
    let piece = 2.0 * (1.0 - (TOLERANCE / radius).min(0.5)).acos();
    let count = (angle.abs() / piece).ceil().clamp(1.0, MOST_PLACES as f64) as usize;
    let place = |i: usize| {
        if i == count {
            return to;
        }
        let part = i as f64 / count as f64;
        let own = radius + (end.length() - radius) * part;
        let flat = centre + DVec2::from_angle(start.to_angle() + angle * part) * own;
        flat.extend(from.z + (to.z - from.z) * part)
    };
    (1..=count).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(text: &str) -> Trace {
        let (traces, _) = read(text).unwrap_or_else(|error| panic!("{text:?}: {error}"));
        traces[0].clone()
    }

    /// mm
    fn places(text: &str) -> Vec<DVec3> {
        trace(text).places.iter().map(|place| place.at / MILLIMETRE).collect()
    }

    fn are_near(places: &[DVec3], wanted: &[[f64; 3]]) -> bool {
        places.len() == wanted.len()
            && places.iter().zip(wanted).all(|(a, b)| a.distance(DVec3::from(*b)) < 1e-9)
    }

    #[test]
    fn lines_are_read_in_every_unit_and_mode() {
        let wanted = [[10.0, 0.0, 120.0], [10.0, 20.0, 120.0], [-5.0, 20.0, 130.0]];
        for text in [
            "G21 G90\nG0 X10 Y0 Z120\nG1 Y20 F600\nX-5 Z130\n",
            "N10 g21 (millimetres; not inches)\nN20 G0 X10Y0Z120 ; start\nn30 g1 y 20 f600*71\nN40 X - 5 Z130\n%\n",
            "G0 X10 Z120\nG91\nG1 Y20\nX-15 Z10\nM2\nG1 X100\n",
            "G20\nG0 X0.39370078740157483 Z4.7244094488188972\nG21\nG1 Y20\nX-5 Z130\n",
            "G28\nG92 X0 Y0 Z0\nG0 X10 Z120\nG1 Y20\nG92 Y0 E0\nX-5 Y0 Z130\n",
        ] {
            assert!(are_near(&places(text), &wanted), "{text:?}: {:?}", places(text));
        }
    }

    #[test]
    fn feeds_give_times() {
        let trace = trace("G0 X0 Y0\nG1 X60 F600\nY30 F300\n");
        let times: Vec<_> = trace.places.iter().filter_map(|place| place.time).collect();
        assert!(times.iter().zip([0.0, 6.0, 12.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{times:?}");
        assert!(!trace.has_height && trace.places.iter().all(|place| !place.jumps));
    }

    #[test]
    fn arcs_are_those_of_their_closed_form() {
        for (text, centre, radius, swept) in [
            ("G0 X20 Y0\nG3 X20 Y0 I-20 J0\n", [0.0, 0.0], 20.0, TAU),
            ("G0 X20 Y0\nG2 I-20\n", [0.0, 0.0], 20.0, -TAU),
            ("G0 X20 Y0\nG3 X0 Y20 I-20 J0\n", [0.0, 0.0], 20.0, TAU / 4.0),
            ("G0 X20 Y0\nG2 X0 Y20 I-20 J0\n", [0.0, 0.0], 20.0, -0.75 * TAU),
            ("G0 X20 Y0\nG3 X0 Y20 R20\n", [0.0, 0.0], 20.0, TAU / 4.0),
            ("G0 X20 Y0\nG3 X0 Y20 R-20\n", [20.0, 20.0], 20.0, 0.75 * TAU),
            ("G0 X20 Y0\nG2 X0 Y20 R20\n", [20.0, 20.0], 20.0, -TAU / 4.0),
            ("G90.1\nG0 X35 Y5\nG3 X15 Y25 I15 J5\n", [15.0, 5.0], 20.0, TAU / 4.0),
            ("G0 X20 Y0\nG3 X-20 Y0 R20 Z0\n", [0.0, 0.0], 20.0, TAU / 2.0),
        ] {
            let places = places(text);
            let count = (places.len() - 1) as f64;
            let start = (places[0].truncate() - DVec2::from(centre)).to_angle();
            for (i, place) in places.iter().enumerate() {
                let angle = start + swept * i as f64 / count;
                let wanted = DVec2::from(centre) + DVec2::from_angle(angle) * radius;
                assert!(place.truncate().distance(wanted) < 1e-9, "{text:?} {i}: {place}, not {wanted}");
            }
            let sagitta = radius * (1.0 - (swept / count / 2.0).cos());
            assert!(sagitta <= 1e-3 * (1.0 + 1e-9), "{text:?}: {sagitta} mm off");
        }
        let helix = places("G0 X20 Y0 Z100\nG3 X20 Y0 Z110 I-20 J0 P2\n");
        let count = (helix.len() - 1) as f64;
        for (i, place) in helix.iter().enumerate() {
            let part = i as f64 / count;
            let wanted = (DVec2::from_angle(2.0 * TAU * part) * 20.0).extend(100.0 + 10.0 * part);
            assert!(place.distance(wanted) < 1e-9, "{i}: {place}");
        }
    }

    #[test]
    fn moves_with_the_pen_up_are_jumps() {
        let wanted = [[0.0, 0.0], [10.0, 0.0], [20.0, 5.0], [30.0, 5.0]];
        for text in [
            "G0 X0 Y0\nG1 X10\nG0 X20 Y5\nG1 X30\n",
            "M5\nG1 X0 Y0\nM3 S90\nG1 X10\nM5\nG1 X20 Y5\nM3\nG1 X30\nM5\nG1 X0 Y0\n",
            "M4 S0\nG1 X0 Y0\nG1 X10 S500\nG1 X20 Y5 S0\nG1 X30 S500\n",
            "G1 Z5\nG1 X0 Y0\nG1 Z-1\nG1 X10\nG1 Z5\nG1 X20 Y5\nG1 Z-1\nG1 X30\nG1 Z5\n",
            "G1 X0 Y0\nG1 X10 E1\nG1 X20 Y5\nG1 X30 E2\nG1 E1\n",
        ] {
            let trace = trace(text);
            let flat: Vec<_> = trace.places.iter().map(|place| (place.at / MILLIMETRE).truncate()).collect();
            let is_near = flat.iter().zip(wanted).all(|(a, b)| a.distance(DVec2::from(b)) < 1e-9);
            assert!(flat.len() == wanted.len() && is_near, "{text:?}: {flat:?}");
            let jumps: Vec<_> = trace.places.iter().map(|place| place.jumps).collect();
            assert_eq!(jumps, [false, false, true, false], "{text:?}");
            assert!(!trace.has_height, "{text:?}");
        }
        assert_eq!(places("G0 X0 Y0\nG0 X10\nG0 Y10\n").len(), 3, "a program of G0 alone");
    }

    #[test]
    fn what_is_not_read_is_refused_or_remarked_on() {
        for (text, error) in [
            ("G1 X1\nG18\n", "2: G18: only arcs in the XY plane"),
            ("G0 X0\nG3 X1\n", "2: an arc needs its centre, I and J, or its radius R"),
            ("G0 X0\nG3 X30 I10\n", "2: the ends of the arc are 10.000 and 20.000 mm from its centre"),
            ("G0 X0\nG2 X30 R10\n", "2: R = 10.000 mm is too short: the ends of the arc are 30.000 mm apart"),
            ("G0 X0\nG2 X0 R10\n", "2: R does not tell the centre of a full circle"),
            ("G0 X0\nG5 X1 I1\n", "2: G5 is not read: only lines (G0, G1) and arcs (G2, G3) are"),
            ("G0 X0\nG1 X#1\n", "2: `G1X#1`: variables"),
            ("G0 X0\nG1 Xten\n", "2: `XTEN`: not a word"),
            ("G0 X0 (open\n", "1: a comment is not closed"),
            ("X1 Y1\n", "1: a place without G0"),
            ("G0 X20000\n", "1: (20000, 0, 0) mm is farther than 10 m"),
            ("G21\nM3\n", "1: there are no moves in it"),
        ] {
            let said = read(text).map(|_| ()).unwrap_err().to_string();
            assert!(said.starts_with(error), "{text:?}: {said}");
        }
        let (_, remarks) = read("G0 X0\nM106 S9\nG1 X10 A5\nG43.4\nM106\n").unwrap();
        assert_eq!(remarks, ["left out, as they draw nothing here: G43.4, M106, words with A"]);
    }

    #[test]
    fn programs_are_told_from_tables() {
        for text in ["; plot\n\nG21\n", "%\nN10 G90\n", "(x)\nM3\n", "g1x5\n"] {
            assert!(is_program(text), "{text:?}");
        }
        for text in ["x,y,z\n1,2,3\n", "0.1,0.2\n", "", "name\n"] {
            assert!(!is_program(text), "{text:?}");
        }
    }
}
