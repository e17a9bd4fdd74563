//! What is made from the scene so that it can be shown: drives, maps, and figures of them.
//!
//! Every value is kept beside what it was made from and made again when that differs. What takes long is made on a thread
//! beside, and what was there before stays on the screen meanwhile.

use std::f64::consts::SQRT_2;
use std::sync::Arc;
use std::time::Instant;

use egui::{ColorImage, Context, TextureOptions};

use crate::acoustics::Aperture;
use crate::app::later::Later;
use crate::cli::{liquid, map};
use crate::drive::Drive;
use crate::field::{self, Average, Colouring, Evaluator, FieldError, Mean, Quantity, Stages, Wanted};
use crate::picture::Picture;
use crate::scene::{Focus, Method, MotionPath, Plane, Scene, check, motion, outline};
use crate::solver::frames::{self, Sequence};
use crate::solver::{self, Problem, Solution};
use crate::ui::view::Lens;
use crate::ui::{Editor, Map, MethodRow, Panel, Pressed, Shown, Sound, Texture};

/// Foci times elements that are solved between two frames; more is solved beside them.
const AT_ONCE: usize = 120 * 256;
/// Pixels of a map, at most.
const MOST_PIXELS: usize = 1 << 23;

type Solved = Result<Arc<Solution>, String>;

/// Everything that a map is made from.
#[derive(Clone, Debug, PartialEq)]
struct Request {
    aperture: Aperture,
    plane: Plane,
    /// Played one after the other; a field is that of the first.
    drives: Vec<Drive>,
    mean: Option<Mean>,
    part: f64,
    size: (usize, usize),
    colouring: Colouring,
}

/// What is played: the scene at rest, or a frame of its motion.
#[derive(Clone, Debug)]
enum Source {
    Still(Arc<Solution>),
    Frame(Arc<Sequence>, usize),
}

#[derive(Debug)]
pub struct Workshop {
    stages: Stages,
    /// The last scene that was asked for, and what came of it.
    solved: Option<(Scene, Solved)>,
    solving: Later<Scene, Solved>,
    bound: Later<Scene, f64>,
    methods: Later<Scene, Vec<MethodRow>>,
    wants_methods: Option<Scene>,
    round: Later<Scene, Result<Arc<Sequence>, String>>,
    /// What the map on the screen was made from.
    drawn: Option<Request>,
    /// Seconds on the window's clock when the motion was last moved on.
    clock: Option<f64>,
}

impl Workshop {
    pub fn new(evaluator: Evaluator) -> Self {
        Self {
            stages: Stages::new(evaluator),
            solved: None,
            solving: Later::default(),
            bound: Later::default(),
            methods: Later::default(),
            wants_methods: None,
            round: Later::default(),
            drawn: None,
            clock: None,
        }
    }

    /// Who computes the field.
    pub fn evaluator(&self) -> String {
        let cpu = || format!("CPU, {}", crate::simd::Isa::best().name());
        self.stages.gpu().map_or_else(cpu, |gpu| gpu.info().name.clone())
    }

    pub fn compare_methods(&mut self, scene: &Scene) {
        self.wants_methods = Some(posed(scene));
    }

    /// How often each stage of the field has run.
    pub fn work(&self) -> field::Work {
        self.stages.work()
    }

    /// Whether something is being made on a thread.
    pub fn is_busy(&self) -> bool {
        self.solving.is_running()
            || self.round.is_running()
            || self.methods.is_running()
            || self.bound.is_running()
    }

    /// Brings everything that is shown up to date.
    pub fn update(&mut self, editor: &mut Editor, shown: &mut Shown, lens: &Lens, ctx: &Context) {
        shown.problem = None;
        let came =
            [self.solving.collect(), self.bound.collect(), self.methods.collect(), self.round.collect()];
        if came.contains(&true) {
            // The panels of this frame were drawn without it.
            ctx.request_repaint();
        }
        self.solve(editor.scene(), shown, ctx);
        self.figures(editor, shown, ctx);
        self.follow(editor, shown, ctx);
        self.play(editor, shown, ctx);
        let source = self.source(editor, shown);
        shown.sound = source.map(|source| sound(editor, &source));
        self.map(editor, shown, lens, ctx);
        shown.warnings = warnings(editor, shown);
    }

    fn solve(&mut self, scene: &Scene, shown: &mut Shown, ctx: &Context) {
        if scene.targets.is_empty() {
            shown.solution = None;
            self.solved = None;
            return;
        }
        let posed = posed(scene);
        if self.solved.as_ref().is_none_or(|(scene, _)| *scene != posed) {
            let start = Instant::now();
            let outcome = match amount(&posed) {
                Err(problem) => Err(problem),
                Ok(amount) if amount > AT_ONCE => {
                    self.solving.ask(&posed, ctx, solve);
                    match self.solving.get(&posed) {
                        Some(solved) => solved.clone(),
                        None => return,
                    }
                }
                Ok(_) => solve(&posed),
            };
            shown.solving = outcome.as_ref().map_or(start.elapsed().as_secs_f64(), |done| done.seconds) * 1e3;
            if let Ok(solution) = &outcome {
                shown.solution = Some(solution.clone());
            }
            self.solved = Some((posed, outcome));
        }
        if let Some((_, Err(problem))) = &self.solved {
            shown.problem = Some(problem.clone());
        }
    }

    /// What is proved of the solution, and all methods side by side.
    fn figures(&mut self, editor: &Editor, shown: &mut Shown, ctx: &Context) {
        shown.certified = None;
        if let Some((scene, Ok(solution))) = &self.solved
            && shown.solution.is_some()
        {
            let is_idle = !ctx.input(|input| input.pointer.any_down());
            if editor.panel == Panel::Solver && is_idle {
                let foci = solution.foci.clone();
                self.bound.ask(scene, ctx, |scene| solver::bound(&Problem::new(&Aperture::new(scene), foci)));
            }
            shown.certified = self.bound.get(scene).map(|&bound| solution.certified(bound));
        }
        if let Some(wanted) = &self.wants_methods {
            self.methods.ask(wanted, ctx, all_methods);
            if let Some(rows) = self.methods.get(wanted) {
                shown.methods = rows.clone();
                self.wants_methods = None;
            }
        }
        shown.is_comparing = self.wants_methods.is_some();
        // A comparison of another scene says nothing of this one; the method chosen makes no difference to it.
        let this = posed(editor.scene());
        let is_of_this = |scene: &Scene| Scene { solver: this.solver.clone(), ..scene.clone() } == this;
        if self.methods.latest().is_none_or(|scene| !is_of_this(scene)) {
            shown.methods.clear();
        }
    }

    /// All frames of the motion, where somebody looks at them.
    fn follow(&mut self, editor: &Editor, shown: &mut Shown, ctx: &Context) {
        let scene = editor.scene();
        let presses = matches!(editor.view.quantity, Quantity::Radiation | Quantity::Dent);
        let is_wanted = matches!(editor.panel, Panel::Motion | Panel::Device)
            || editor.playback.frame.is_some()
            || presses;
        let moves = scene.motion.path != MotionPath::None && !scene.targets.is_empty();
        shown.round = None;
        shown.is_following = false;
        if !moves || !is_wanted {
            return;
        }
        let moving = Scene { motion: scene.motion.clone(), ..posed(scene) };
        if let Err(error) = check::check(&moving) {
            shown.problem = Some(error.to_string());
            return;
        }
        self.round.ask(&moving, ctx, |scene| {
            frames::follow(scene).map(Arc::new).map_err(|error| error.to_string())
        });
        match self.round.get(&moving) {
            Some(Ok(round)) => shown.round = Some(round.clone()),
            Some(Err(problem)) => shown.problem = Some(problem.clone()),
            None => shown.is_following = self.round.is_running(),
        }
    }

    /// Moves the motion on by the time that went by.
    fn play(&mut self, editor: &mut Editor, shown: &Shown, ctx: &Context) {
        let now = ctx.input(|input| input.time);
        let before = self.clock.replace(now);
        let count = motion::count(editor.scene());
        let rate = editor.scene().motion.rate;
        let playback = &mut editor.playback;
        if let Some(frame) = &mut playback.frame {
            *frame = (*frame).min(count.saturating_sub(1));
        }
        if !playback.playing {
            self.clock = None;
            return;
        }
        ctx.request_repaint();
        let (Some(before), Some(_)) = (before, &shown.round) else { return };
        playback.part = (playback.part + (now - before) * rate / playback.slowness.max(1.0)).rem_euclid(1.0);
        playback.frame = Some(((playback.part * count as f64) as usize).min(count.saturating_sub(1)));
    }

    fn source(&self, editor: &Editor, shown: &Shown) -> Option<Source> {
        match (&shown.round, editor.playback.frame) {
            (Some(round), Some(frame)) if frame < round.frames.len() => {
                Some(Source::Frame(round.clone(), frame))
            }
            _ => shown.solution.clone().map(Source::Still),
        }
    }

    fn map(&mut self, editor: &Editor, shown: &mut Shown, lens: &Lens, ctx: &Context) {
        let Some(request) = request(editor, shown, lens, ctx) else {
            shown.map = None;
            shown.pressed = None;
            self.drawn = None;
            return;
        };
        if self.drawn.as_ref() == Some(&request) {
            return;
        }
        let start = Instant::now();
        match self.make(&request, editor, shown, lens, ctx) {
            Ok(()) => {
                shown.mapping = start.elapsed().as_secs_f64() * 1e3;
                self.drawn = Some(request);
            }
            Err(FieldError::Gpu(error)) => {
                self.stages = Stages::new(Evaluator::Cpu);
                shown.evaluator = self.evaluator();
                shown.problem = Some(format!("{error}; the CPU computes the field from now on"));
                ctx.request_repaint();
            }
            Err(error) => {
                shown.problem.get_or_insert(error.to_string());
            }
        }
    }

    fn make(
        &mut self,
        request: &Request,
        editor: &Editor,
        shown: &mut Shown,
        lens: &Lens,
        ctx: &Context,
    ) -> Result<(), FieldError> {
        let (width, height) = request.size;
        let quantity = request.colouring.quantity;
        let mut pressed = None;
        let (largest, error, how, numbers) = match request.average() {
            None => {
                let map = self.stages.map(&request.wanted())?;
                (f64::from(map.peak) / SQRT_2, map.error, map.how.clone(), None)
            }
            Some(average) => {
                let map = self.stages.average(&average)?.clone();
                let beyond = map.dent.as_ref().and_then(|dent| liquid::beyond_linear_theory(dent.slope));
                pressed = Some(Pressed { force: map.force, dent: map.dent, beyond });
                (f64::from(map.largest), map.error, map.how, Some(self.stages.read_average(&average)?))
            }
        };
        let colours = self.colours(request)?;
        let image = ColorImage::from_rgba_premultiplied([width, height], colours.as_flattened());
        let options =
            TextureOptions { magnification: egui::TextureFilter::Nearest, ..TextureOptions::LINEAR };
        let texture = match shown.map.take() {
            Some(mut map) => {
                map.texture.0.set(image, options);
                map.texture
            }
            None => Texture(ctx.load_texture("map", image, options)),
        };
        shown.pressed = pressed;
        shown.map = Some(Map {
            texture,
            cut: editor.view.cut,
            axes: editor.view.axes(editor.scene()),
            window: lens.window,
            rect: lens.rect,
            quantity,
            largest,
            error,
            how,
            width,
            height,
            numbers,
        });
        Ok(())
    }

    fn colours(&mut self, request: &Request) -> Result<&[[u8; 4]], FieldError> {
        match request.average() {
            None => self.stages.colours(&request.wanted(), &request.colouring),
            Some(average) => self.stages.average_colours(&average, &request.colouring),
        }
    }

    /// The map on the screen as a picture.
    pub fn picture(&mut self) -> Option<Picture> {
        let request = self.drawn.clone()?;
        let colours = self.colours(&request).ok()?;
        Some(Picture::from_field_order(request.size.0, request.size.1, colours.as_flattened()))
    }

    /// The map's numbers, height and width first.
    pub fn numbers(&mut self) -> Option<(Vec<u64>, Vec<f32>)> {
        let request = self.drawn.clone()?;
        let values = match request.average() {
            Some(average) => self.stages.read_average(&average).ok()?,
            None => {
                let field = self.stages.read(&request.wanted()).ok()?;
                field.iter().map(|&p| request.colouring.quantity.of(p)).collect()
            }
        };
        Some((vec![request.size.1 as u64, request.size.0 as u64], values))
    }
}

impl Request {
    fn wanted(&self) -> Wanted<'_> {
        let (width, height) = self.size;
        Wanted { aperture: &self.aperture, plane: &self.plane, drive: &self.drives[0], width, height }
    }

    fn average(&self) -> Option<Average<'_>> {
        let (width, height) = self.size;
        let mean = self.mean.clone()?;
        let (aperture, plane, drives, part) = (&self.aperture, &self.plane, &self.drives[..], self.part);
        Some(Average { aperture, plane, drives, mean, part, width, height })
    }
}

/// The part of a scene that its drive follows from.
fn posed(scene: &Scene) -> Scene {
    Scene {
        medium: scene.medium.clone(),
        array: scene.array.clone(),
        targets: scene.targets.clone(),
        solver: scene.solver.clone(),
        ..Scene::default()
    }
}

/// Foci times elements.
fn amount(scene: &Scene) -> Result<usize, String> {
    check::check(scene).map_err(|error| error.to_string())?;
    let foci = outline::foci(scene).map_err(|error| error.to_string())?;
    Ok(foci.len() * scene.array.elements())
}

fn solve(scene: &Scene) -> Solved {
    solver::solve(scene).map(Arc::new).map_err(|error| error.to_string())
}

fn all_methods(scene: &Scene) -> Vec<MethodRow> {
    let row = |method| {
        let mut scene = scene.clone();
        scene.solver.method = method;
        MethodRow { method, solution: solve(&scene) }
    };
    Method::ALL.map(row).to_vec()
}

/// What is played and what arrives, as a board with few phases plays it if that is asked for.
fn sound(editor: &Editor, source: &Source) -> Sound {
    let aperture = Aperture::new(editor.scene());
    let (drive, foci, pressures): (&Drive, &[Focus], _) = match source {
        Source::Still(solution) => (&solution.drive, &solution.foci, &solution.pressures),
        Source::Frame(round, frame) => {
            let frame = &round.frames[*frame];
            (&frame.drive, &frame.foci, &frame.pressures)
        }
    };
    let (mut drive, mut pressures) = (drive.clone(), pressures.clone());
    if let Some(levels) = editor.levels {
        drive = drive.at_levels(levels);
        if drive.phases.len() == aperture.positions.len() {
            let problem = Problem::new(&aperture, foci.to_vec());
            pressures = problem.transfer.pressure(&drive.excitation(&aperture.driven));
        }
    }
    Sound { aperture, drive, foci: foci.to_vec(), pressures }
}

/// What map the screen needs. `None` where nothing plays.
fn request(editor: &Editor, shown: &Shown, lens: &Lens, ctx: &Context) -> Option<Request> {
    let (scene, view) = (editor.scene(), &editor.view);
    let sound = shown.sound.as_ref()?;
    // Until the scene is solved again, the drive may be that of another array.
    if sound.drive.phases.len() != sound.aperture.positions.len() {
        return None;
    }
    let pixels = |points: f32| ((points * ctx.pixels_per_point()).round() as usize).max(1);
    let size = (pixels(lens.rect.width()), pixels(lens.rect.height()));
    if size.0 * size.1 > MOST_PIXELS {
        return None;
    }
    let mean = map::mean(scene, view.quantity);
    let drives = match (&mean, &shown.round, editor.playback.frame) {
        // A liquid is slow and feels the mean of the round.
        (Some(_), Some(round), None) => round.frames.iter().map(|frame| frame.drive.clone()).collect(),
        _ => vec![sound.drive.clone()],
    };
    let full = view.full.map(|full| match view.quantity {
        Quantity::Rms => (full * SQRT_2) as f32,
        _ => full as f32,
    });
    Some(Request {
        aperture: sound.aperture.clone(),
        plane: view.plane(scene, lens),
        drives,
        part: if mean.is_some() { scene.modulation.mean_square() } else { 1.0 },
        mean,
        size,
        colouring: Colouring { quantity: view.quantity, table: view.table(), full },
    })
}

/// What to know before trusting what is seen.
fn warnings(editor: &Editor, shown: &Shown) -> Vec<String> {
    let mut warnings = shown.solution.as_ref().map_or_else(Vec::new, |solution| solution.warnings.clone());
    if let Some(beyond) = shown.pressed.as_ref().and_then(|pressed| pressed.beyond.clone()) {
        warnings.insert(0, beyond);
    }
    let tolerance = editor.scene().plane.tolerance;
    if let Some(map) = shown.map.as_ref().filter(|map| tolerance > 0.0 && map.error > tolerance) {
        warnings.push(format!(
            "the map's error is {:.1e} of its peak, more than the {tolerance:e} wanted",
            map.error
        ));
    }
    warnings
}
