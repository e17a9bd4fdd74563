//! Values derived from the scene for display: drives, their figures, and the current moment of motions.
//!
//! Every value is kept with its inputs and recomputed when they differ. Long computations run on threads; meanwhile
//! the previous value stays on screen.
//!
//! - A scene at rest is solved between two frames, up to 120 foci of a 256-element array ([`Solving`]). Larger
//!   scenes, motions and the comparison of methods are computed on a thread ([`Later`]), one of each kind at a time.
//! - Force, depth, displaced volume and slope are those of the scene's own plane, computed on a thread when nothing
//!   is dragged.
//! - While a board plays the motion, the window shows the board's frame: the time since its first frame, modulo the
//!   cycle.
//! - An instantaneous pressure is formed from the existing sound: a new moment of the wave needs no superposition,
//!   and frames are drawn for it only while it runs and is visible.
//! - A comparison is a second [`Mapping`] with its own stages, created when switched on and dropped when switched
//!   off; both share one colour range.

use egui::Context;
use web_time::Duration;

use crate::acoustics::Aperture;
use crate::app::comparison::{self, Comparison};
use crate::app::job::{CompareMethods, Follow, Job, Solve};
use crate::app::mapping::{Look, Mapping};
use crate::app::posing::{self, Source};
use crate::app::preparing::Preparing;
use crate::app::screen::Screen;
use crate::app::space::Spacing;
use crate::field::{Evaluator, Quantity, Request, missed};

#[cfg(not(target_arch = "wasm32"))]
use crate::gauge::Gauge;
use crate::picture::Picture;
use crate::scene::{Scene, check, motion};
use crate::studio::later::Later;
use crate::studio::performance::Performance;
use crate::studio::posing::{posed, posed_in_motion};
use crate::studio::reach;
use crate::studio::solving::{Followed, Solved, Solving, Step};
use crate::ui::board::{Plays, sentence};
use crate::ui::part::Now;
#[cfg(not(target_arch = "wasm32"))]
use crate::ui::part::wake;
use crate::ui::space::Stage;
use crate::ui::view::Lens;
use crate::ui::{Editor, Map, MethodRow, Moment, Notice, Panel, Playback, Shown, Sound, sound};

/// Displayed duration of a period of the sound, s.
const OSCILLATION_PERIOD: f64 = 2.0;
/// Interval between two of its pictures.
const OSCILLATION_STEP: Duration = Duration::from_millis(33);

const BEING_SOLVED: &str = "Solving… the map still shows the previous drawing.";
const AFTER_DRAG: &str = "Solving waits until nothing is dragged… the map still shows the previous drive.";
const AT_REST: &str = "Solving the frames of the motion… the map shows the scene at rest.";
const BEFORE: &str = "Solving the frames of the motion… the map still shows the previous ones.";

const MAKING_WAVES: &str = "Computing the waves…";
/// Interval between two frames of a motion on the screen, s, at least.
const SHORTEST_FRAME: f64 = 1.0 / 60.0;

/// Time of the last update of a running animation, in seconds on the window's clock; `None` at rest.
#[derive(Debug, Default)]
struct Clock(Option<f64>);

impl Clock {
    /// s since the last call, if it ran then and runs now.
    fn passed(&mut self, runs: bool, ctx: &Context) -> Option<f64> {
        let now = ctx.input(|input| input.time);
        let before = std::mem::replace(&mut self.0, runs.then_some(now))?;
        runs.then_some(now - before)
    }
}

/// The displayed content.
#[derive(Clone, Copy, Debug)]
pub enum Seen<'a> {
    /// A map, and its comparison.
    Map {
        lens: &'a Lens,
        beside: Option<&'a Lens>,
    },
    Space(&'a Stage),
}

/// Scene, levels and source of a sound, and whether the answers of bodies to it are known.
type Sounding = (Scene, Option<u32>, Source, bool);

#[derive(Debug)]
pub struct Workshop {
    pub mapping: Mapping,
    solving: Solving,
    /// Warnings about targets out of reach, with their scene.
    reach: Option<(Scene, Vec<String>)>,
    solved: Later<Scene, Solved>,
    methods: Later<Scene, Vec<MethodRow>>,
    wants_methods: Option<Scene>,
    round: Later<Scene, Followed>,
    comparison: Option<Comparison>,
    pub spacing: Spacing,
    preparing: Preparing,
    motion: Clock,
    /// Start of the board's motion (s on the window's clock), and the playback state before.
    board: Option<(f64, Playback)>,
    /// The played sound, and its inputs.
    sounded: Option<(Sounding, Sound)>,
    oscillation: Clock,
    flight: Clock,
}

impl Workshop {
    pub fn new(evaluator: Evaluator, screen: Option<Screen>) -> Self {
        Self {
            mapping: Mapping::new(evaluator, screen),
            solving: Solving::default(),
            reach: None,
            solved: Later::default(),
            methods: Later::default(),
            wants_methods: None,
            round: Later::default(),
            comparison: None,
            spacing: Spacing::default(),
            preparing: Preparing::default(),
            motion: Clock::default(),
            board: None,
            sounded: None,
            oscillation: Clock::default(),
            flight: Clock::default(),
        }
    }

    pub fn compare_methods(&mut self, scene: &Scene) {
        self.wants_methods = Some(posed(scene));
    }

    /// The map on the screen without overlays, and the second map or the difference of a comparison.
    pub fn pictures(&mut self) -> Option<(Picture, Option<Picture>)> {
        let second = self.comparison.as_mut().and_then(Comparison::picture);
        Some((self.mapping.picture()?, second))
    }

    /// The request of the second map of a comparison.
    pub fn second_request(&self) -> Option<&Request> {
        self.comparison.as_ref()?.request()
    }

    /// Whether background work is running, or GPU results are pending.
    pub fn is_busy(&self) -> bool {
        self.mapping.is_awaiting()
            || self.solved.is_running()
            || self.round.is_running()
            || self.methods.is_running()
            || self.comparison.as_ref().is_some_and(Comparison::is_busy)
            || self.spacing.is_running()
    }

    /// Updates everything displayed.
    pub fn update(&mut self, editor: &mut Editor, shown: &mut Shown, seen: &Seen<'_>, ctx: &Context) {
        shown.problem = None;
        shown.pending = None;
        let came = [
            self.solved.collect(),
            self.methods.collect(),
            self.round.collect(),
            self.spacing.collect(),
            editor.parts.collect(),
        ];
        if came.contains(&true) {
            // The panels of this frame were drawn without it.
            ctx.request_repaint();
        }
        self.solve(editor, shown, ctx);
        self.compare_all(editor, shown, ctx);
        self.follow(editor, shown, ctx);
        self.play(editor, shown, ctx);
        self.oscillate(editor, shown, ctx);
        self.fly(editor, ctx);
        let source = self.source(editor, shown);
        shown.sound = source.as_ref().map(|source| self.sound(editor, source));
        match *seen {
            Seen::Map { lens, beside } => {
                self.spacing.rest(shown);
                self.map(editor, shown, lens, ctx);
                self.compare(editor, shown, source.as_ref(), beside, ctx);
            }
            Seen::Space(stage) => {
                if let Err(error) = self.spacing.update(editor, shown, stage, &self.mapping, ctx) {
                    self.mapping.lose_gpu(error);
                    ctx.request_repaint();
                }
            }
        }
        self.update_parts(editor, shown, seen, ctx);
        let rests = !ctx.input(|input| input.pointer.any_down()) && !editor.playback.playing;
        self.preparing.update(shown.sound.as_ref().map(|sound| &sound.aperture), rests, ctx);
        shown.warnings = warnings(editor, shown);
        shown.warnings.extend_from_slice(self.reached(ctx));
    }

    /// The map of the played drive.
    fn map(&mut self, editor: &Editor, shown: &mut Shown, lens: &Lens, ctx: &Context) {
        if awaits_frames(editor, shown) {
            return;
        }
        let plane = editor.view.plane(editor.scene(), lens);
        let waves = editor.parts.waves.surface(&editor.playback, editor.scene(), &plane);
        let waves = waves.filter(|_| is_of_waves(editor));
        if waves.is_none() && is_of_waves(editor) && is_of_this(shown.map.as_ref(), editor) {
            shown.pending.get_or_insert_with(|| MAKING_WAVES.to_owned());
            return;
        }
        let look = Look {
            scene: editor.scene(),
            view: &editor.view,
            sound: shown.sound.as_ref().filter(|_| editor.view.suits(editor.scene())),
            drives: sound::drives(
                shown.round.as_ref(),
                shown.sound.as_ref(),
                editor.playback,
                editor.view.quantity,
            ),
            moment: editor.oscillation.part,
            full: comparison::common_range(editor, shown),
            surface: waves.as_ref(),
            lens,
            is_veil: false,
        };
        let done = self.mapping.update(&look, &mut shown.map, ctx);
        if let Some(text) = done.gave_up {
            shown.evaluator = self.mapping.evaluator();
            shown.notice = Some(Notice { text, is_error: true });
        }
        if let Some(problem) = done.problem {
            shown.problem.get_or_insert(problem);
        }
        shown.mapping = done.milliseconds.unwrap_or(shown.mapping);
        shown.on_gpu = done.on_gpu.unwrap_or(shown.on_gpu);
    }

    /// Updates the comparison; releases it when it is closed.
    fn compare(
        &mut self,
        editor: &Editor,
        shown: &mut Shown,
        source: Option<&Source>,
        lens: Option<&Lens>,
        ctx: &Context,
    ) {
        let (Some(compare), Some(lens)) = (&editor.compare, lens) else {
            (self.comparison, shown.beside) = (None, None);
            return;
        };
        let comparison = self.comparison.get_or_insert_with(|| Comparison::new(self.mapping.twin()));
        comparison.update((editor, compare), shown, source, lens, &mut self.mapping, ctx);
    }

    fn solve(&mut self, editor: &Editor, shown: &mut Shown, ctx: &Context) {
        let scene = editor.scene();
        shown.board.steadied = None;
        if !scene.has_drive() {
            self.solved.keep(None);
            self.solving.clear();
            shown.solution = None;
            return;
        }
        let mut posed = posed(scene);
        if shown.board.plays == Plays::Scene {
            let profile = editor.board.profile;
            let steadied = profile.steady(&mut posed, editor.board.baud().unwrap_or(profile.baud()));
            shown.board.steadied = steadied.as_deref().map(sentence);
        }
        self.solved.keep(Some(&posed));
        let rests = !ctx.input(|input| input.pointer.any_down());
        let mut step = self.solving.next(&posed, rests);
        if step == Some(Step::Quick) && self.solving.solve_at_once(&posed) {
            step = self.solving.next(&posed, rests);
        }
        // A body that moves has other answers in every frame.
        let waits = !rests && !posed.bodies.is_empty() && !Aperture::new(&posed).is_prepared();
        if step.is_some() && !waits {
            ask_for::<Solve>(&mut self.solved, &posed, ctx);
            if let Some(solved) = self.solved.get(&posed) {
                self.solving.take(&posed, solved.clone());
            }
        }
        if let Some(last) = &self.solving.last {
            (shown.solving, shown.solution) = (1e3 * last.seconds, Some(last.clone()));
        }
        match self.solving.solved.as_ref().filter(|(scene, _)| *scene == posed) {
            None => shown.pending = Some(if waits { AFTER_DRAG } else { BEING_SOLVED }.to_owned()),
            Some((_, Err(problem))) => shown.problem = Some(problem.clone()),
            Some((_, Ok(_))) => {}
        }
    }

    /// Targets out of the array's reach, updated once nothing is dragged.
    fn reached(&mut self, ctx: &Context) -> &[String] {
        let Some((posed, _)) = &self.solving.solved else { return &[] };
        let is_known = self.reach.as_ref().is_some_and(|(scene, _)| scene == posed);
        if !is_known && !ctx.input(|input| input.pointer.any_down()) {
            let cut = reach::cut_short(&Aperture::new(posed));
            let warnings = reach::of_targets(posed).into_iter().chain(cut);
            self.reach = Some((posed.clone(), warnings.map(|warning| warning.to_string()).collect()));
        }
        self.reach.as_ref().map_or(&[], |(_, warnings)| warnings)
    }

    /// Requests the values of the parts.
    fn update_parts(&self, editor: &mut Editor, shown: &Shown, seen: &Seen<'_>, ctx: &Context) {
        let Editor { document, view, panel, layout, playback, levels, selection, pointed, parts, .. } =
            editor;
        let scene = &document.scene;
        let sound = shown.sound.as_ref();
        let now = Now {
            scene,
            view,
            panel: (!layout.presents).then_some(*panel),
            playback: *playback,
            levels: *levels,
            sound: sound.filter(|sound| sound.drive().phases.len() == sound.aperture.positions.len()),
            solution: shown.solution.as_ref(),
            solved: self
                .solving
                .solved
                .as_ref()
                .and_then(|(scene, solved)| Some((scene, solved.as_ref().ok()?))),
            plays: shown.board.plays,
            cycle: shown.round.as_ref(),
            has_selection: !selection.is_empty(),
            focus: sound::focus(scene, selection, sound),
            pointer: *pointed,
            lens: match *seen {
                Seen::Map { lens, .. } => Some(lens),
                Seen::Space(_) => None,
            },
            rests: !ctx.input(|input| input.pointer.any_down()),
        };
        parts.update(&now, ctx);
    }

    /// The comparison of methods.
    fn compare_all(&mut self, editor: &Editor, shown: &mut Shown, ctx: &Context) {
        if let Some(wanted) = &self.wants_methods {
            ask_for::<CompareMethods>(&mut self.methods, wanted, ctx);
            if let Some(rows) = self.methods.get(wanted) {
                shown.methods = rows.clone();
                self.wants_methods = None;
            }
        }
        shown.is_comparing = self.wants_methods.is_some();
        // A comparison is only valid for its scene; the chosen method does not matter.
        let this = posed(editor.scene());
        let is_of_this = |scene: &Scene| {
            Scene { solver: this.solver.clone(), drive: this.drive.clone(), ..scene.clone() } == this
        };
        if self.methods.latest().is_none_or(|scene| !is_of_this(scene)) {
            shown.methods.clear();
        }
    }

    /// All frames of the motion, if displayed.
    fn follow(&mut self, editor: &Editor, shown: &mut Shown, ctx: &Context) {
        let scene = editor.scene();
        let presses = editor.view.quantity.declaration().is_slow;
        let is_wanted = matches!(editor.panel, Panel::Motion | Panel::Felt | Panel::Device)
            || editor.playback.moment != Moment::Rest
            || editor.parts.flight.form.from.is_some()
            || presses;
        let moves = motion::moves(scene) && scene.has_drive();
        shown.round = None;
        shown.is_following = false;
        if !moves || !is_wanted {
            self.round.keep(None);
            return;
        }
        let moving = posed_in_motion(scene);
        if let Err(error) = check::check(&moving) {
            shown.problem = Some(error.to_string());
            return;
        }
        ask_for::<Follow>(&mut self.round, &moving, ctx);
        match self.round.get(&moving) {
            Some(Ok(round)) => shown.round = Some(round.clone()),
            Some(Err(problem)) => shown.problem = Some(problem.clone()),
            None => shown.is_following = self.round.is_running(),
        }
        if awaits_frames(editor, shown) {
            shown.pending = Some(BEFORE.to_owned());
        } else if shown.is_following && (presses || editor.playback.moment != Moment::Rest) {
            shown.pending = Some(AT_REST.to_owned());
        }
    }

    /// Moves the motion, or the waves, on by the time that went by.
    fn play(&mut self, editor: &mut Editor, shown: &Shown, ctx: &Context) {
        let quantity = editor.view.quantity;
        let is_of_waves = is_of_waves(editor);
        let cycle = motion::cycle(editor.scene()).map(|cycle| (cycle.frames as usize, cycle.rate));
        let (count, rate) = match editor.parts.waves.schedule(editor.scene()) {
            Some(schedule) if is_of_waves => (schedule.pictures, schedule.rate() / schedule.pictures as f64),
            Some(_) | None => cycle.unwrap_or((1, 0.0)),
        };
        let is_there = match is_of_waves {
            true => matches!(editor.parts.waves.exact(), Some(Ok(_))),
            false => shown.round.is_some(),
        };
        let playback = &mut editor.playback;
        let last = count.saturating_sub(1);
        if let Moment::Frame(index) | Moment::Wave(index) = &mut playback.moment {
            *index = (*index).min(last);
        }
        let on_board = self.on_board(playback, shown, ctx);
        let runs = playback.playing && playback.moment.playing(quantity).is_some();
        let passed = self.motion.passed(runs, ctx);
        if !runs || !is_there {
            return;
        }
        let rate = on_board.map_or(rate, |(rate, _)| rate);
        let per_second = rate / playback.slowness.max(1.0);
        if let Some(passed) = passed {
            let done = playback.part + passed * per_second;
            playback.part = match on_board {
                Some((rate, since)) if playback.slowness <= 1.0 => (since * rate).rem_euclid(1.0),
                Some(_) | None if done >= 1.0 && !playback.loops => {
                    playback.playing = false;
                    last as f64 / count.max(1) as f64
                }
                Some(_) | None => done.rem_euclid(1.0),
            };
        }
        let index = ((playback.part * count as f64) as usize).min(last);
        if let Moment::Frame(shown) | Moment::Wave(shown) = &mut playback.moment {
            *shown = index;
        }
        // A frame of the window for each of the motion, as far as it can draw them.
        let to_next = ((index + 1) as f64 / count.max(1) as f64 - playback.part) / per_second.max(1e-9);
        ctx.request_repaint_after(Duration::from_secs_f64(to_next.clamp(SHORTEST_FRAME, 1.0)));
    }

    /// Cycles per second of the board's motion, and the time (s) since its start. Playback starts with it, in real
    /// time, and ends with it.
    fn on_board(&mut self, playback: &mut Playback, shown: &Shown, ctx: &Context) -> Option<(f64, f64)> {
        let health = shown.board.health.as_ref().filter(|health| health.in_place);
        let rates = health.filter(|_| shown.board.plays == Plays::Motion).and_then(|health| health.rates);
        let Some(rates) = rates else {
            if let Some((_, before)) = self.board.take() {
                *playback = before;
            }
            return None;
        };
        let now = ctx.input(|input| input.time);
        let since = match &self.board {
            Some((since, _)) => *since,
            None => {
                self.board = Some((now, Playback { playing: false, ..*playback }));
                let moment = Moment::Frame(0);
                *playback = Playback { moment, playing: true, slowness: 1.0, part: 0.0, loops: true };
                now
            }
        };
        Some((rates.cycles, now - since))
    }

    /// Advances the wave in slow motion, while displayed.
    fn oscillate(&mut self, editor: &mut Editor, shown: &Shown, ctx: &Context) {
        let is_shown =
            editor.view.quantity == Quantity::Instantaneous && shown.sound.is_some() && !editor.space.is_on;
        let runs = editor.oscillation.playing && is_shown;
        if let Some(passed) = self.oscillation.passed(runs, ctx) {
            let part = &mut editor.oscillation.part;
            *part = (*part + passed / OSCILLATION_PERIOD).rem_euclid(1.0);
        }
        if runs {
            ctx.request_repaint_after(OSCILLATION_STEP);
        }
    }

    /// Moves a released bead on.
    fn fly(&mut self, editor: &mut Editor, ctx: &Context) {
        let flight = &mut editor.parts.flight;
        let passed = self.flight.passed(flight.form.playing, ctx);
        if flight.go_on(passed.unwrap_or(0.0)) {
            // A motion that carries it is shown in step.
            if let Some(cycle) = motion::cycle(&editor.document.scene) {
                let part = (flight.form.time * cycle.rate).rem_euclid(1.0);
                let frame = (part * f64::from(cycle.frames)) as usize;
                editor.playback.playing = false;
                (editor.playback.moment, editor.playback.part) = (Moment::Frame(frame), part);
            }
            ctx.request_repaint_after(OSCILLATION_STEP);
        }
    }

    fn source(&self, editor: &Editor, shown: &Shown) -> Option<Source> {
        let has_mean = editor.space.is_on || editor.view.quantity.declaration().has_mean;
        match (&shown.round, editor.playback.moment) {
            (Some(round), moment @ Moment::Frame(frame)) if frame < round.frames.len() => {
                Some(Source { performance: Performance::Motion(round.clone()), moment })
            }
            (Some(round), moment @ Moment::Mean) if has_mean => {
                Some(Source { performance: Performance::Motion(round.clone()), moment })
            }
            (_, Moment::Rest | Moment::Frame(_) | Moment::Mean | Moment::Wave(_)) => {
                let performance = Performance::Still(shown.solution.clone()?);
                Some(Source { performance, moment: Moment::Rest })
            }
        }
    }

    /// The sound of a source.
    fn sound(&mut self, editor: &Editor, source: &Source) -> Sound {
        let is_kept = |((scene, levels, kept, is_known), sound): &&(Sounding, Sound)| {
            *levels == editor.levels
                && kept == source
                && scene == editor.scene()
                && (*is_known || !sound.is_at_hand())
        };
        if let Some((_, sound)) = self.sounded.as_ref().filter(is_kept) {
            return sound.clone();
        }
        let sound = posing::sound(editor.scene(), editor.levels, source);
        let sounding = (editor.scene().clone(), editor.levels, source.clone(), sound.is_at_hand());
        self.sounded = Some((sounding, sound.clone()));
        sound
    }
}

/// Whether the waves of a liquid are to be shown.
fn is_of_waves(editor: &Editor) -> bool {
    matches!(editor.playback.moment.of(editor.view.quantity), Moment::Wave(_))
}

/// Whether a map shows the quantity of the view.
fn is_of_this(map: Option<&Map>, editor: &Editor) -> bool {
    map.is_some_and(|map| map.quantity == editor.view.quantity && map.cut == editor.view.cut)
}

/// Requests the result of a job on a scene; a job for another scene is cancelled.
fn ask_for<J: Job>(later: &mut Later<Scene, J::Made>, scene: &Scene, ctx: &Context) {
    later.keep(Some(scene));
    let ctx = ctx.clone();
    #[cfg(not(target_arch = "wasm32"))]
    later.ask_with(scene, wake(&ctx), move |scene, answer| {
        let mut so_far = |made| {
            answer.so_far(made);
            ctx.request_repaint();
        };
        Gauge::default().until(&answer.cancel).lead(|| J::make_with(scene, &mut so_far))
    });
    #[cfg(target_arch = "wasm32")]
    later.ask_by(scene, |answer| {
        let answered = move |made| {
            answer.last(made);
            ctx.request_repaint();
        };
        crate::app::worker::ask::<J>(scene, answered);
        true
    });
}

/// Whether the map waits for the frames of the motion, without which the skin feels something else.
fn awaits_frames(editor: &Editor, shown: &Shown) -> bool {
    shown.is_following && editor.view.quantity.declaration().of_skin
}

/// Warnings about the displayed results.
fn warnings(editor: &Editor, shown: &Shown) -> Vec<String> {
    let of_solution = shown.solution.iter().flat_map(|solution| &solution.warnings);
    let mut warnings: Vec<_> = of_solution.map(ToString::to_string).collect();
    let radiation = editor.parts.radiation.newest().and_then(Option::as_ref);
    if let Some(beyond) = radiation.and_then(|radiation| radiation.beyond.clone()) {
        warnings.insert(0, beyond);
    }
    warnings.extend(crate::studio::motion::remarks(editor.scene()));
    warnings.extend(shown.board.steadied.clone());
    warnings.extend(editor.parts.scattering.newest().and_then(|found| found.problem.clone()));
    let map = shown.map.as_ref();
    let tolerance = editor.view.quantity.declaration().tolerance(editor.scene());
    warnings.extend(map.and_then(|map| missed(map.error, tolerance)));
    warnings
}
