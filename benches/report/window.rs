//! CPU time of the window's frames, without a screen.

use std::ops::Range;

use anyhow::Context;
use eframe::egui::{self, Event, Key, Modifiers, PointerButton, Pos2, RawInput, Rect, pos2, vec2};
use glam::{DVec2, DVec3};
use serde_json::{Value, json};

use sonoglyph::app::Window;
use sonoglyph::bench::Report;
use sonoglyph::bench::time::{ROUNDS, Spent, Spread, Times, digits, median};
use sonoglyph::field::{Evaluator, Quantity, Scale};
use sonoglyph::picture::chart::{Chart, Series};
use sonoglyph::scene::{Scene, Shape, Target};
use sonoglyph::ui::Editor;
use sonoglyph::ui::document::Document;
use sonoglyph::ui::view::Lens;

const SIZE: egui::Vec2 = vec2(1280.0, 800.0);
/// Window sizes of drags.
const SIZES: [egui::Vec2; 4] = [vec2(640.0, 480.0), SIZE, vec2(1920.0, 1080.0), vec2(2560.0, 1440.0)];
const QUICK_SIZES: [egui::Vec2; 2] = [vec2(640.0, 480.0), vec2(1920.0, 1080.0)];
/// Successive frames.
const FRAMES: usize = 20;
const QUICK_FRAMES: usize = 8;
const FRAMES_PER_SECOND: usize = 60;
/// s between frames.
const STEP: f64 = 1.0 / FRAMES_PER_SECOND as f64;

const DRAG: &str = "drag one of 8 foci";
const EXACT: &str = "drag, every pixel evaluated";

struct Record {
    what: &'static str,
    size: egui::Vec2,
    times: Option<Times>,
    /// CPU time with every pixel evaluated over that of these frames.
    ratio: Option<Spread>,
    /// Median wall ms of the field and of the solver.
    parts: Option<[f64; 2]>,
    /// Number of drawn frames.
    frames: Option<usize>,
}

/// Measures drags, waves, typing, start, hovering and idle frames; `quick` takes fewer frames.
///
/// # Errors
/// The window shows no map.
pub fn run(quick: bool) -> anyhow::Result<Report> {
    let frames = if quick { QUICK_FRAMES } else { FRAMES };
    let mut records = drag(&DISPLAYS, SIZE, frames)?;
    let others: &[egui::Vec2] = if quick { &QUICK_SIZES } else { &SIZES };
    for &size in others.iter().filter(|&&size| size != SIZE) {
        records.extend(drag(&DISPLAYS[..2], size, QUICK_FRAMES)?);
    }
    records.push(Record::timed("instantaneous pressure", oscillation(ROUNDS * frames)));
    records.push(Record::timed("type HIT, per letter", typing()));
    records.push(Record::timed("start to first map", start()));
    records.push(Record::counted("the pointer moves", hover()));
    records.push(Record::counted("nothing happens", idle()));
    Ok(Report {
        header: vec!["action", "window", "CPU ms (wall)", "speed", "quartiles", "field ms", "solve ms", "frames"],
        rows: records.iter().map(row).collect(),
        notes: vec![
            "Medians of one frame, without the renderer. speed: CPU time of a drag with every pixel evaluated over \
             that of this one, measured alternately. field, solve: wall ms."
                .to_owned(),
            "frames: drawn after one movement of the pointer until hovering has settled, and in an idle second."
                .to_owned(),
        ],
        charts: vec![("window-pixels".to_owned(), chart(&records))],
        records: records.iter().map(json).collect(),
    })
}

/// The window with its context, off the screen.
struct Screen {
    ctx: egui::Context,
    size: egui::Vec2,
    window: Window,
    time: f64,
    /// Whether the last frame asked for another one at once.
    wants_more: bool,
}

impl Screen {
    fn bare(scene: Scene, size: egui::Vec2) -> Self {
        let ctx = egui::Context::default();
        let window = Window::new(&ctx, Document::new(scene, "bench"), Evaluator::Cpu);
        Self { ctx, size, window, time: 0.0, wants_more: true }
    }

    fn new(scene: Scene, size: egui::Vec2) -> Self {
        let mut screen = Self::bare(scene, size);
        screen.settle();
        screen
    }

    fn settle(&mut self) {
        for _ in 0..5 {
            self.frame(Vec::new());
        }
    }

    /// Times a frame without the renderer: panels, solver, field, colours and triangles.
    fn frame(&mut self, events: Vec<Event>) -> Spent {
        self.time += STEP;
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, self.size)),
            time: Some(self.time),
            events,
            focused: true,
            ..RawInput::default()
        };
        let window = &mut self.window;
        let (spent, (output, triangles)) = Spent::once(|| {
            let mut output = self.ctx.run_ui(input, |ui| window.frame(ui));
            // No renderer takes the textures.
            output.textures_delta.clear();
            let shapes = std::mem::take(&mut output.shapes);
            let triangles = self.ctx.tessellate(shapes, output.pixels_per_point);
            (output, triangles)
        });
        drop(triangles);
        self.wants_more = output.viewport_output.values().any(|output| output.repaint_delay.is_zero());
        spent
    }

    /// Number of drawn frames in the next second.
    fn frames_that_follow(&mut self) -> usize {
        (0..FRAMES_PER_SECOND)
            .filter(|_| {
                self.wants_more && {
                    self.frame(Vec::new());
                    true
                }
            })
            .count()
    }

    fn place(&self, point: DVec3) -> Option<Pos2> {
        let map = self.window.shown().map.as_ref()?;
        let lens = Lens { rect: map.rect, window: map.window };
        Some(lens.screen(DVec2::new(point.x, point.y)))
    }

    fn press(&mut self, at: Pos2, pressed: bool) {
        let button = PointerButton::Primary;
        let event = Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE };
        self.frame(vec![Event::PointerMoved(at)]);
        self.frame(vec![event]);
    }

    fn key(&mut self, key: Key) {
        let event = |pressed| Event::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: Modifiers::NONE,
        };
        self.frame(vec![event(true), event(false)]);
    }
}

/// A display of the map during a drag: its name, and its settings.
type Display = (&'static str, fn(&mut Editor));

/// Starts with the baseline.
const DISPLAYS: [Display; 6] = [
    (EXACT, |editor| editor.document.scene.plane.tolerance = 0.0),
    (DRAG, |_| ()),
    ("  with contours", |editor| editor.view.contours = true),
    ("  in decibels", |editor| editor.view.scale = Scale::Logarithmic),
    ("  depression", |editor| editor.view.quantity = Quantity::Depression),
    ("  depression, shaded", |editor| {
        editor.view.quantity = Quantity::Depression;
        editor.view.shaded = true;
    }),
];

fn eight_foci() -> [DVec3; 8] {
    let at = |i: usize| (DVec2::from_angle(i as f64 * std::f64::consts::TAU / 8.0) * 0.04).extend(0.1);
    std::array::from_fn(at)
}

fn scene(foci: &[DVec3]) -> Scene {
    let target = |&at: &DVec3| Target::new(Shape::Point { at });
    Scene { targets: foci.iter().map(target).collect(), ..Scene::default() }
}

/// A drag of one of eight foci.
struct Drag {
    what: &'static str,
    screen: Screen,
    from: Pos2,
    times: Times,
    field: Vec<f64>,
    solve: Vec<f64>,
}

impl Drag {
    fn new(&(what, display): &Display, size: egui::Vec2) -> anyhow::Result<Self> {
        let foci = eight_foci();
        let mut screen = Screen::new(scene(&foci), size);
        display(screen.window.editor_mut());
        screen.settle();
        let from = screen.place(foci[0]).context("the window shows no map")?;
        if !screen.window.editor().view.is_shaded() {
            screen.press(from, true);
        }
        Ok(Self { what, screen, from, times: Times::default(), field: Vec::new(), solve: Vec::new() })
    }

    /// Successive frames, as in a real drag, so that few of them meet the caches of the previous display.
    fn turn(&mut self, numbers: Range<usize>) {
        let frames: Vec<_> = numbers.map(|i| self.frame(i)).collect();
        self.times.push(Spent::median(&frames));
    }

    /// Foci of a shaded surface cannot be dragged: their coordinates are changed instead.
    fn frame(&mut self, i: usize) -> Spent {
        let offset = vec2((i as f32 * 0.1).sin() * 40.0, 3.0 + i as f32);
        let editor = self.screen.window.editor_mut();
        if editor.view.is_shaded() {
            let at = eight_foci()[0] + DVec3::new(f64::from(offset.x), f64::from(-offset.y), 0.0) * 3e-4;
            editor.document.scene.targets[0].shape = Shape::Point { at };
        }
        let spent = self.screen.frame(vec![Event::PointerMoved(self.from + offset)]);
        self.field.push(self.screen.window.shown().mapping);
        self.solve.push(self.screen.window.shown().solving);
        spent
    }
}

/// The displays alternate after `frames` frames.
fn drag(displays: &[Display], size: egui::Vec2, frames: usize) -> anyhow::Result<Vec<Record>> {
    let mut drags: Vec<Drag> =
        displays.iter().map(|display| Drag::new(display, size)).collect::<anyhow::Result<_>>()?;
    for round in 0..ROUNDS {
        let numbers = round * frames..(round + 1) * frames;
        drags.iter_mut().for_each(|drag| drag.turn(numbers.clone()));
    }
    let exact = drags[0].times.clone();
    let record = |Drag { what, times, field, solve, .. }: Drag| Record {
        what,
        size,
        ratio: Some(exact.over(&times)),
        times: Some(times),
        parts: Some([median(&field), median(&solve)]),
        frames: None,
    };
    Ok(drags.into_iter().map(record).collect())
}

/// Frames of the running waves.
fn oscillation(frames: usize) -> Times {
    let mut screen = Screen::new(scene(&eight_foci()), SIZE);
    screen.window.editor_mut().view.quantity = Quantity::Instantaneous;
    screen.settle();
    (0..frames).map(|_| screen.frame(Vec::new())).collect()
}

/// Per letter, with the next frame, which adds the figures.
fn typing() -> Times {
    let mut times = Times::default();
    for _ in 0..10 {
        let mut screen = Screen::new(Scene::default(), SIZE);
        screen.key(Key::T);
        let middle = pos2(470.0, 400.0);
        screen.press(middle, true);
        screen.press(middle, false);
        for letter in ["H", "I", "T"] {
            let letter = Event::Text(letter.to_owned());
            times.push(Spent::once(|| [vec![letter], Vec::new()].map(|events| screen.frame(events))).0);
        }
    }
    times
}

/// Number of frames drawn for one movement of the pointer.
fn hover() -> usize {
    let mut screen = Screen::new(Scene::default(), SIZE);
    while screen.wants_more {
        screen.frame(Vec::new());
    }
    screen.frame(vec![Event::PointerMoved(pos2(400.0, 300.0))]);
    1 + screen.frames_that_follow()
}

/// Number of frames drawn in a second, after a second to come to rest.
fn idle() -> usize {
    let mut screen = Screen::new(Scene::default(), SIZE);
    screen.frames_that_follow();
    screen.frames_that_follow()
}

/// From a new window to the first map of eight foci.
fn start() -> Times {
    let first_picture = || {
        let mut screen = Screen::bare(scene(&eight_foci()), SIZE);
        while screen.window.shown().map.is_none() {
            screen.frame(Vec::new());
        }
    };
    (0..5).map(|_| Spent::once(first_picture).0).collect()
}

impl Record {
    fn timed(what: &'static str, times: Times) -> Self {
        Self { what, size: SIZE, times: Some(times), ratio: None, parts: None, frames: None }
    }

    fn counted(what: &'static str, frames: usize) -> Self {
        Self { what, size: SIZE, times: None, ratio: None, parts: None, frames: Some(frames) }
    }
}

fn row(record: &Record) -> Vec<String> {
    let or_dash = |text: Option<String>| text.unwrap_or("-".to_owned());
    vec![
        record.what.to_owned(),
        format!("{}x{}", record.size.x, record.size.y),
        or_dash(record.times.as_ref().map(Times::text)),
        or_dash(record.ratio.map(|ratio| ratio.text())),
        or_dash(record.ratio.map(|ratio| ratio.quartiles_text())),
        or_dash(record.parts.map(|[field, _]| digits(field))),
        or_dash(record.parts.map(|[_, solve]| digits(solve))),
        or_dash(record.frames.map(|frames| frames.to_string())),
    ]
}

fn json(record: &Record) -> Value {
    json!({
        "what": record.what.trim(),
        "width": record.size.x,
        "height": record.size.y,
        "time": record.times.as_ref().map(Times::json),
        "time_ratio": record.ratio.map(|ratio| ratio.json()),
        "field_wall_ms": record.parts.map(|parts| parts[0]),
        "solve_wall_ms": record.parts.map(|parts| parts[1]),
        "frames": record.frames,
    })
}

/// Time of a frame against the window's pixels.
fn chart(records: &[Record]) -> Chart {
    let series = |what: &str| {
        let dragged = records.iter().filter(|record| record.what == what);
        let place = |record: &Record| {
            Some((f64::from(record.size.x) * f64::from(record.size.y), record.times.as_ref()?.cpu_ms()))
        };
        let mut points: Vec<_> = dragged.filter_map(place).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    Chart {
        title: "Time of a frame against pixels: drag of one of 8 foci, 256 elements".to_owned(),
        x_label: "pixels of the window".to_owned(),
        y_label: "CPU-ms per frame, without the renderer".to_owned(),
        series: vec![
            Series { name: "every pixel".to_owned(), points: series(EXACT) },
            Series { name: "tolerance 1e-3".to_owned(), points: series(DRAG) },
        ],
        levels: Vec::new(),
    }
}
