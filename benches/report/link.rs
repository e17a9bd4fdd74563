//! Throughput, latency and modulation of links to virtual boards, which accept bytes at their bit rate.

use std::collections::HashSet;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use serde_json::{Value, json};

use sonoglyph::bench::Report;
use sonoglyph::device::board::{Board, Setup, Shown};
use sonoglyph::device::declaration::Level;
use sonoglyph::device::levels::Levels;
use sonoglyph::device::link::{Content, Event, Link, Settings};
use sonoglyph::device::profile::Profile;
use sonoglyph::scene::{Envelope, Modulation};

/// Number of different frames.
const FRAMES: u16 = 200;
/// Frames per second, beyond the capacity of any line.
const FASTEST: f64 = 20_000.0;
/// Fraction of the line's capacity. Native boards play faster motions from their own store.
const STREAMED: f64 = 0.85;
/// Interval of frames on a screen during a drag.
const DRAG: Duration = Duration::from_micros(16_667);
/// Capacity for played frames until they are compared.
const KEPT: usize = 1 << 20;

pub fn run(quick: bool) -> anyhow::Result<Report> {
    let lasts = Duration::from_secs(if quick { 3 } else { 30 });
    let mut rows = Rows::default();
    for (profile, baud) in
        [(Profile::Native, 3_000_000), (Profile::Native, 2_000_000), (Profile::SonicSurface, 230_400)]
    {
        rows.throughput(profile, baud, lasts)?;
    }
    for (profile, baud) in [(Profile::Native, 2_000_000), (Profile::SonicSurface, 230_400)] {
        rows.latency(profile, baud, lasts / 6)?;
    }
    rows.modulation(Profile::SonicSurface, 200.0, lasts / 6)?;
    Ok(Report {
        header: vec!["board", "baud", "measured", "value", "remarks"],
        rows: rows.cells,
        notes: vec![format!(
            "Virtual boards on pseudo-terminals that accept bytes at their bit rate. A native board is sent {} % of \
             the line's capacity; it plays faster motions from its own store.",
            100.0 * STREAMED
        )],
        records: rows.records,
        charts: Vec::new(),
    })
}

/// A virtual board, and a link that has found it.
struct Pair {
    link: Link,
    _board: Board,
    shown: Receiver<Shown>,
}

impl Pair {
    fn new(profile: Profile, baud: u32) -> anyhow::Result<Self> {
        let (sender, shown) = sync_channel(KEPT);
        // A frame that does not fit would count as lost.
        let watch = move |frame: &Shown| drop(sender.try_send(frame.clone()));
        let board = Board::start(Setup::new(profile), Box::new(watch))?;
        let settings = Settings { port: board.path().to_owned(), profile, baud: Some(baud) };
        let link = Link::open(settings, Box::new(|| {}))?;
        match link.event_within(Duration::from_secs(10)) {
            Some(Event::Ready(_)) => Ok(Self { link, _board: board, shown }),
            other => bail!("the virtual board was not found: {other:?}"),
        }
    }

    fn next(&self) -> anyhow::Result<Shown> {
        self.shown.recv_timeout(Duration::from_secs(10)).context("the virtual board plays no frame")
    }
}

/// A frame that differs from the others, with pseudorandom phases.
fn frame(profile: Profile, number: u16) -> Levels {
    let Some(full) = profile.level(1.0, 0.0) else { return Levels::off(profile) };
    let level = |n: usize| {
        let mixed = (n as u32).wrapping_mul(2_654_435_769).wrapping_add(u32::from(number) * 40_503) >> 16;
        Level { delay: (mixed % u32::from(profile.levels())) as u16, amplitude: full.amplitude }
    };
    Levels { profile, channels: (0..profile.elements()).map(|n| Some(level(n))).collect() }
}

#[derive(Default)]
struct Rows {
    cells: Vec<Vec<String>>,
    records: Vec<Value>,
}

impl Rows {
    fn add(&mut self, profile: Profile, baud: u32, measured: &str, value: String, part: String) {
        self.cells.push(vec![profile.name().to_owned(), baud.to_string(), measured.to_owned(), value, part]);
    }

    /// Throughput in frames per second; counts frames that were never sent as corrupted.
    fn throughput(&mut self, profile: Profile, baud: u32, lasts: Duration) -> anyhow::Result<()> {
        let pair = Pair::new(profile, baud)?;
        let frames: Vec<_> = (0..FRAMES).map(|n| frame(profile, n)).collect();
        let mut sent: HashSet<_> = frames.iter().cloned().collect();
        // A link starts with silence after every connection.
        sent.insert(Levels::off(profile));
        let possible = profile.frames_per_second(baud);
        let rate = if profile.answers() { STREAMED * possible } else { FASTEST };
        pair.link.show(Content::Motion { frames, rate });
        // The first frames wait for an idle line.
        for _ in 0..10 {
            pair.next()?;
        }
        let begun = pair.next()?.at;
        let (mut count, mut corrupted, mut last) = (0u32, 0u32, begun);
        while last < begun + lasts {
            let shown = pair.next()?;
            count += 1;
            corrupted += u32::from(!sent.contains(&shown.levels));
            last = shown.at;
        }
        let rate = f64::from(count) / (last - begun).as_secs_f64();
        let health = pair.link.health();
        let (refused, lost) = (health.refused, health.found - 1);
        let part = format!(
            "{:.1} % of {possible:.0}; {corrupted} of {count} corrupted, {refused} refused, {lost} connections lost",
            100.0 * rate / possible
        );
        self.add(profile, baud, "frames/s", format!("{rate:.1}"), part);
        self.records.push(json!({
            "board": profile.name(), "baud": baud, "measured": "frames/s", "frames_per_second": rate,
            "possible": possible, "part": rate / possible, "frames": count, "torn": corrupted, "refused": refused,
            "lost": lost, "seconds": lasts.as_secs_f64(),
        }));
        Ok(())
    }

    /// Latency from a new frame to its last byte on the line, with a new frame per frame of a screen.
    fn latency(&mut self, profile: Profile, baud: u32, lasts: Duration) -> anyhow::Result<()> {
        let pair = Pair::new(profile, baud)?;
        let begun = Instant::now();
        let mut delays = Vec::new();
        let mut number = 0;
        while begun.elapsed() < lasts {
            let levels = frame(profile, number);
            number = (number + 1) % FRAMES;
            let asked = Instant::now();
            pair.link.show(Content::Still(levels.clone()));
            let shown = loop {
                let shown = pair.next()?;
                if shown.levels == levels {
                    break shown;
                }
            };
            delays.push(shown.at.saturating_duration_since(asked).as_secs_f64() * 1e3);
            std::thread::sleep((asked + DRAG).saturating_duration_since(Instant::now()));
        }
        delays.sort_by(f64::total_cmp);
        let at = |part: usize| delays[(delays.len() * part / 100).min(delays.len() - 1)];
        let frame = 1e3 / profile.frames_per_second(baud);
        let value = format!("{:.2} ms, 95 % within {:.2} ms", at(50), at(95));
        self.add(profile, baud, "new frame to last byte", value, format!("a frame takes {frame:.2} ms"));
        self.records.push(json!({
            "board": profile.name(), "baud": baud, "measured": "delay", "delay_median_ms": at(50),
            "delay_95_ms": at(95), "frame_ms": frame,
        }));
        Ok(())
    }

    /// Half periods of a modulation by swaps, as received by the board.
    fn modulation(&mut self, profile: Profile, frequency: f64, lasts: Duration) -> anyhow::Result<()> {
        let baud = profile.baud();
        let pair = Pair::new(profile, baud)?;
        pair.link.modulate(Modulation { shape: Envelope::Square, frequency, ..Modulation::default() });
        pair.link.show(Content::Still(frame(profile, 1)));
        // The first frames load both buffers.
        for _ in 0..10 {
            pair.next()?;
        }
        let mut before = pair.next()?.at;
        let (begun, mut halves) = (before, Vec::new());
        while before < begun + lasts {
            let at = pair.next()?.at;
            halves.push(at.saturating_duration_since(before).as_secs_f64());
            before = at;
        }
        halves.sort_by(f64::total_cmp);
        let median = halves[halves.len() / 2];
        let mut off: Vec<_> = halves.iter().map(|half| (half - median).abs() * 1e3).collect();
        off.sort_by(f64::total_cmp);
        let (jitter, error) = (off[off.len() * 95 / 100], (2.0 * median * frequency - 1.0).abs());
        let value = format!("{:.2} Hz, half periods ± {jitter:.3} ms (95 %)", 0.5 / median);
        self.add(
            profile,
            baud,
            "modulation by swaps",
            value,
            format!("{:.2} % off {frequency} Hz", 100.0 * error),
        );
        self.records.push(json!({
            "board": profile.name(), "baud": baud, "measured": "modulation", "asked_hertz": frequency,
            "median_hertz": 0.5 / median, "error": error, "jitter_ms": jitter,
        }));
        Ok(())
    }
}
