//! `sonoglyph bench window`: what the window's frames cost, without a screen.

use std::time::Instant;

use cpu_time::ProcessTime;
use eframe::egui::{self, Event, Key, Modifiers, PointerButton, Pos2, RawInput, Rect, pos2, vec2};
use glam::{DVec2, DVec3};

use crate::app::Window;
use crate::cli::output::say;
use crate::field::{Evaluator, Quantity};
use crate::scene::{Scene, Shape, Target};
use crate::ui::Editor;
use crate::ui::document::Document;
use crate::ui::view::Lens;

const SIZE: egui::Vec2 = vec2(1280.0, 800.0);
const FRAMES: usize = 120;
/// s between frames.
const STEP: f64 = 1.0 / 60.0;

/// The window with its context, and nobody to look at it.
struct Screen {
    ctx: egui::Context,
    window: Window,
    time: f64,
    /// Whether the last frame asked for another one at once.
    wants_more: bool,
}

impl Screen {
    fn bare(scene: Scene) -> Self {
        let ctx = egui::Context::default();
        let window = Window::new(&ctx, Document::new(scene, "bench"), Evaluator::Cpu);
        Self { ctx, window, time: 0.0, wants_more: true }
    }

    fn new(scene: Scene) -> Self {
        let mut screen = Self::bare(scene);
        screen.settle();
        screen
    }

    fn settle(&mut self) {
        for _ in 0..5 {
            self.frame(Vec::new());
        }
    }

    /// CPU time (ms) of a frame: panels, solving, field, colours and triangles, but for what the renderer does with them.
    fn frame(&mut self, events: Vec<Event>) -> f64 {
        self.time += STEP;
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, SIZE)),
            time: Some(self.time),
            events,
            focused: true,
            ..RawInput::default()
        };
        let start = ProcessTime::now();
        let window = &mut self.window;
        let mut output = self.ctx.run_ui(input, |ui| window.frame(ui));
        // There is no renderer that would take them.
        output.textures_delta.clear();
        let triangles = self.ctx.tessellate(output.shapes, output.pixels_per_point);
        let spent = start.elapsed().as_secs_f64() * 1e3;
        drop(triangles);
        self.wants_more = output.viewport_output.values().any(|output| output.repaint_delay.is_zero());
        spent
    }

    /// How many of the frames of the next second are drawn.
    fn frames_that_follow(&mut self) -> usize {
        (0..60)
            .filter(|_| {
                self.wants_more && {
                    self.frame(Vec::new());
                    true
                }
            })
            .count()
    }

    fn place(&self, point: DVec3) -> Option<Pos2> {
        let map = self.window.shown.map.as_ref()?;
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

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Prints what starting, dragging, typing and doing nothing cost.
///
/// # Errors
/// Standard output takes nothing.
pub fn run() -> anyhow::Result<()> {
    say!("CPU time per frame of a {} x {} window, median; the renderer comes on top", SIZE.x, SIZE.y)?;
    type Look = fn(&mut Editor);
    let looks: [(&str, Look); 5] = [
        ("drag one of 8 foci", |_| ()),
        ("  with contours", |editor| editor.view.contours = true),
        ("  in decibels", |editor| editor.view.scale = crate::field::Scale::Logarithmic),
        ("  over its dent", |editor| editor.view.quantity = Quantity::Dent),
        ("  over its dent, shaded", |editor| {
            editor.view.quantity = Quantity::Dent;
            editor.view.shaded = true;
        }),
    ];
    for (name, look) in looks {
        let (all, field, solve) = drag(look);
        say!("{name:<24} {all:6.2} ms in all, field {field:.2} ms, solve {solve:.2} ms (elapsed)")?;
    }
    say!("{:<24} {:6.2} ms", "a moment of the waves", oscillation())?;
    say!("{:<24} {:6.2} ms per letter", "type HIT", typing())?;
    say!("{:<24} {:6} frames, with those in which hovering settles", "the pointer moves", hover())?;
    say!("{:<24} {:6} frames in a second", "nothing happens", idle())?;
    let (spent, passed) = start();
    say!("{:<24} {spent:6.2} ms, {passed:.2} ms elapsed", "start to first picture")
}

fn eight_foci() -> [DVec3; 8] {
    let at = |i: usize| (DVec2::from_angle(i as f64 * std::f64::consts::TAU / 8.0) * 0.04).extend(0.1);
    std::array::from_fn(at)
}

fn scene(foci: &[DVec3]) -> Scene {
    let target = |&at: &DVec3| Target::new(Shape::Point { at });
    Scene { targets: foci.iter().map(target).collect(), ..Scene::default() }
}

/// Moves one of eight foci, which a shaded surface takes no pointer for, by its number.
fn drag(look: fn(&mut Editor)) -> (f64, f64, f64) {
    let foci = eight_foci();
    let mut screen = Screen::new(scene(&foci));
    look(&mut screen.window.editor);
    screen.settle();
    let Some(from) = screen.place(foci[0]) else { return (0.0, 0.0, 0.0) };
    let is_shaded = screen.window.editor.view.is_shaded();
    if !is_shaded {
        screen.press(from, true);
    }
    let (mut all, mut field, mut solve) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..FRAMES {
        let offset = vec2((i as f32 * 0.1).sin() * 40.0, 3.0 + i as f32);
        if is_shaded {
            let at = foci[0] + DVec3::new(f64::from(offset.x), f64::from(-offset.y), 0.0) * 3e-4;
            screen.window.editor.document.scene.targets[0].shape = Shape::Point { at };
        }
        all.push(screen.frame(vec![Event::PointerMoved(from + offset)]));
        field.push(screen.window.shown.mapping);
        solve.push(screen.window.shown.solving);
    }
    (median(all), median(field), median(solve))
}

/// The waves as they run.
fn oscillation() -> f64 {
    let mut screen = Screen::new(scene(&eight_foci()));
    screen.window.editor.view.quantity = Quantity::Instantaneous;
    screen.settle();
    median((0..FRAMES).map(|_| screen.frame(Vec::new())).collect())
}

/// Letter by letter, with the figures that follow in the next frame.
fn typing() -> f64 {
    let mut spent = Vec::new();
    for _ in 0..10 {
        let mut screen = Screen::new(Scene::default());
        screen.key(Key::T);
        let middle = pos2(470.0, 400.0);
        screen.press(middle, true);
        screen.press(middle, false);
        for letter in ["H", "I", "T"] {
            let first = screen.frame(vec![Event::Text(letter.to_owned())]);
            spent.push(first + screen.frame(Vec::new()));
        }
    }
    median(spent)
}

/// Frames that are drawn for one move of the pointer.
fn hover() -> usize {
    let mut screen = Screen::new(Scene::default());
    while screen.wants_more {
        screen.frame(Vec::new());
    }
    screen.frame(vec![Event::PointerMoved(pos2(400.0, 300.0))]);
    1 + screen.frames_that_follow()
}

fn idle() -> usize {
    Screen::new(Scene::default()).frames_that_follow()
}

/// CPU and elapsed time (ms) from nothing to a frame with a map of eight foci on it.
fn start() -> (f64, f64) {
    let runs: Vec<_> = (0..5)
        .map(|_| {
            let (spent, passed) = (ProcessTime::now(), Instant::now());
            let mut screen = Screen::bare(scene(&eight_foci()));
            while screen.window.shown.map.is_none() {
                screen.frame(Vec::new());
            }
            (spent.elapsed().as_secs_f64() * 1e3, passed.elapsed().as_secs_f64() * 1e3)
        })
        .collect();
    (median(runs.iter().map(|run| run.0).collect()), median(runs.iter().map(|run| run.1).collect()))
}
