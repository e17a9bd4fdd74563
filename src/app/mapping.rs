//! The displayed map: its inputs, and the stages that recompute it when they differ.
//!
//! The map fills the canvas for any view of the plane: zooming makes another plane. It is recomputed when its
//! inputs ([`Wanted`]) differ (`==`). A phase map with brightness by amplitude is covered by a veil: a second
//! [`Mapping`] of the RMS pressure, opaque at zero and transparent at the peak (`picture::colour::veil`).
//!
//! If the GPU does not draw the window, as in a page, each requested map is displayed before the next is requested:
//! otherwise a drag, which requests a map per frame, would never display any. On the desktop the same happens for
//! `Window::new` with a GPU, which `tests/window/gpu.rs` tests.

use std::f64::consts::TAU;

use egui::{Color32, ColorImage, Context, TextureId, TextureOptions};
use web_time::Instant;

use crate::app::screen::Screen;
use crate::app::slow::{SlowMaps, is_slow};
use crate::drive::Drive;
use crate::field::Picture as Painted;
use crate::field::gpu::Texture as OnGpu;
use crate::field::sound::PRESSURE;
use crate::field::{
    Colouring, Evaluator, FieldError, Gpu, GpuError, Map as Values, Quantity, Request, Stages, Work,
};
use crate::picture::Picture;
use crate::picture::relief::{self, Place, Relief};
use crate::scene::Scene;
use crate::studio::map;
use crate::ui::parts::waves::{self, Surface};
use crate::ui::theme;
use crate::ui::view::{Axes, Cut, Lens, View};
use crate::ui::{Map, Sound, Texture};

/// Pixels of a map, at most.
const MOST_PIXELS: usize = 1 << 23;
/// Pixels from one point of a shaded surface, or of light in motion, to the next.
const COARSE_STEP: usize = 2;

/// Enlarged pixels stay sharp.
pub const NEAREST: TextureOptions =
    TextureOptions { magnification: egui::TextureFilter::Nearest, ..TextureOptions::LINEAR };

/// The inputs of a displayed picture.
#[derive(Clone, Debug, PartialEq)]
struct Wanted {
    /// Request, with fewer pixels for shaded views, and for the first of slow maps.
    request: Request,
    colouring: Colouring,
    /// Pixels of the picture.
    picture: (usize, usize),
    /// How a shaded surface is looked at.
    relief: Option<relief::Look>,
    /// Levels of contour lines, as [`map::contour`] has them.
    contours: Vec<f64>,
}

/// The displayed map, and its pending parts.
#[derive(Debug)]
struct Drawn {
    wanted: Wanted,
    /// Picture of a shaded surface.
    picture: Option<Picture>,
    lacks_figures: bool,
    lacks_contours: bool,
}

/// A picture with values pending on a GPU or a thread, and its position.
#[derive(Clone, Debug)]
struct Awaited {
    wanted: Wanted,
    frame: Frame,
    asked: Instant,
}

/// The position of a picture.
#[derive(Clone, Copy, Debug)]
struct Frame {
    cut: Cut,
    axes: Axes,
    lens: Lens,
}

/// The inputs of a displayed map.
#[derive(Debug)]
pub struct Look<'a> {
    pub scene: &'a Scene,
    pub view: &'a View,
    pub sound: Option<&'a Sound>,
    /// Drives shown in the map.
    pub drives: Vec<Drive>,
    /// Moment of a period, in [0, 1).
    pub moment: f64,
    /// The value of the last colour, unless chosen in the view.
    pub full: Option<f64>,
    pub lens: &'a Lens,
    /// A moving surface of the liquid, instead of the one at rest.
    pub surface: Option<&'a Surface>,
    /// Shows the pressure that dims the view's quantity, instead of the quantity.
    pub is_veil: bool,
}

/// Results besides the map.
#[derive(Debug, Default)]
pub struct Done {
    /// Time to make the map, ms.
    pub milliseconds: Option<f64>,
    /// GPU time (ms), if figures have arrived and it is measurable.
    pub on_gpu: Option<Option<f64>>,
    pub problem: Option<String>,
    /// The reason for abandoning the GPU.
    pub gave_up: Option<String>,
}

pub struct Mapping {
    stages: Stages,
    /// The screen, if its device also computes the field.
    screen: Option<Screen>,
    /// The picture registered with egui on that device, and its id.
    registered: Option<(OnGpu, TextureId)>,
    drawn: Option<Drawn>,
    /// For slow maps, and for GPUs whose pictures do not stay on the screen's device.
    awaited: Option<Box<Awaited>>,
    slow: SlowMaps,
    /// The latest request of the skin under elements with a response, and its inputs.
    responding: Option<Box<Responding>>,
    /// The reason for abandoning the GPU, until reported.
    given_up: Option<GpuError>,
    has_lost_screen: bool,
    /// The veil over a phase map, with its own stages.
    veil: Option<Box<Veil>>,
}

/// A request that took long to make: its drives are many instants of those of the scene.
#[derive(Debug)]
struct Responding {
    scene: Scene,
    drives: Vec<Drive>,
    quantity: Quantity,
    request: Request,
}

/// A map over another.
struct Veil {
    mapping: Mapping,
    map: Option<Map>,
}

impl std::fmt::Debug for Mapping {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Mapping")
            .field("stages", &self.stages)
            .field("drawn", &self.drawn)
            .finish_non_exhaustive()
    }
}

impl Mapping {
    /// With a `screen`, pictures stay on its device, shared with the evaluator.
    pub fn new(evaluator: Evaluator, screen: Option<Screen>) -> Self {
        let gpu = if let Evaluator::Gpu(gpu) = &evaluator { Some(gpu.twin()) } else { None };
        Self {
            stages: Stages::new(evaluator),
            screen,
            registered: None,
            drawn: None,
            awaited: None,
            slow: SlowMaps::new(gpu),
            responding: None,
            given_up: None,
            has_lost_screen: false,
            veil: None,
        }
    }

    /// The field evaluator.
    pub fn evaluator(&self) -> String {
        let cpu = || format!("CPU, {}", crate::simd::Isa::best().name());
        self.stages.gpu().map_or_else(cpu, |gpu| gpu.info().name.clone())
    }

    /// The GPU that computes the field, if one does.
    pub fn gpu(&self) -> Option<&Gpu> {
        self.stages.gpu()
    }

    /// The screen, if its device also computes the field.
    pub fn screen(&self) -> Option<&Screen> {
        self.screen.as_ref()
    }

    /// Replaces a failed GPU by the CPU.
    pub fn lose_gpu(&mut self, error: GpuError) {
        self.give_up_gpu(error);
    }

    /// Run counts of the field's stages.
    pub fn work(&self) -> Work {
        self.stages.work()
    }

    /// Whether the device that draws the window is lost, so that no picture can be displayed.
    pub fn has_lost_screen(&self) -> bool {
        self.has_lost_screen
    }

    /// A second mapping on the same device.
    pub fn twin(&self) -> Self {
        let gpu = self.gpu().map(|gpu| Evaluator::Gpu(Box::new(gpu.twin())));
        Self::new(gpu.unwrap_or(Evaluator::Cpu), self.screen.clone())
    }

    /// Whether the map is complete.
    pub fn is_complete(&self) -> bool {
        self.awaited.is_none() && self.drawn.as_ref().is_some_and(|drawn| !drawn.lacks_figures)
    }

    /// Whether values of a picture are pending.
    pub fn is_awaiting(&self) -> bool {
        self.awaited.is_some()
            || self.slow.is_running()
            || self.veil.as_ref().is_some_and(|veil| veil.mapping.is_awaiting())
    }

    /// The request of the displayed map.
    pub fn request(&self) -> Option<&Request> {
        self.drawn.as_ref().map(|drawn| &drawn.wanted.request)
    }

    /// Updates the map and its veil.
    pub fn update(&mut self, look: &Look<'_>, map: &mut Option<Map>, ctx: &Context) -> Done {
        let mut done = self.update_own(look, map, ctx);
        if look.view.veil().is_none() {
            self.veil = None;
        } else {
            let twin = self.veil.take().unwrap_or_else(|| Box::new(Veil { mapping: self.twin(), map: None }));
            let veil = self.veil.insert(twin);
            let look = Look { drives: look.drives.clone(), is_veil: true, ..*look };
            let over = veil.mapping.update_own(&look, &mut veil.map, ctx);
            done.problem = done.problem.or(over.problem);
            self.has_lost_screen |= veil.mapping.has_lost_screen;
        }
        if let Some(map) = map {
            let over = self.veil.as_ref().and_then(|veil| veil.map.as_ref());
            map.veil = over.map(|over| over.texture.id());
        }
        done
    }

    fn update_own(&mut self, look: &Look<'_>, map: &mut Option<Map>, ctx: &Context) -> Done {
        let mut done = Done::default();
        if let Some(error) = self.given_up.take() {
            done.gave_up = Some(format!("{error}; the CPU computes the field from now on"));
        }
        let Some(wanted) = self.wanted(look, ctx) else {
            (*map, self.drawn, self.awaited) = (None, None, None);
            return done;
        };
        let is_drawn = self.drawn.as_ref().is_some_and(|drawn| drawn.wanted == wanted);
        self.slow.collect();
        let waits = is_slow(&wanted.request) && !self.stages.has(&wanted.request);
        if !waits {
            self.slow.stop();
        }
        let frame = Frame { cut: look.view.cut, axes: look.view.axes(look.scene), lens: *look.lens };
        let made = if is_drawn {
            self.awaited = None;
            self.complete(map, &mut done)
        } else if waits {
            self.await_slow(wanted, frame, map, &mut done, ctx)
        } else if self.stages.gpu().is_some() && self.screen.is_none() {
            self.await_values(wanted, frame, map, &mut done, ctx)
        } else {
            self.make(wanted, (frame, Instant::now()), map, &mut done, ctx)
        };
        match made {
            Ok(()) => {}
            Err(FieldError::Gpu(error)) => {
                self.give_up_gpu(error);
                ctx.request_repaint();
            }
            Err(error) => done.problem = Some(error.to_string()),
        }
        let is_under_way =
            self.drawn.as_ref().is_some_and(|drawn| drawn.lacks_figures || drawn.lacks_contours);
        // A thread wakes the window by itself.
        if is_under_way || (self.awaited.is_some() && !self.slow.is_running()) {
            ctx.request_repaint();
        }
        done
    }

    /// The required picture. `None` without a drive.
    fn wanted(&mut self, look: &Look<'_>, ctx: &Context) -> Option<Wanted> {
        let Look { scene, view, lens, .. } = *look;
        let sound = look.sound?;
        // Until the scene is solved again, the drive may belong to another array.
        if sound.drive().phases.len() != sound.aperture.positions.len() {
            return None;
        }
        let pixels = |points: f32| ((points * ctx.pixels_per_point()).round() as usize).max(1);
        let picture = (pixels(lens.rect.width()), pixels(lens.rect.height()));
        if picture.0 * picture.1 > MOST_PIXELS {
            return None;
        }
        let is_shaded = view.is_shaded();
        // The light of a moving surface is not interpolated: every ray is followed.
        let is_light = view.quantity.declaration().of_light;
        let is_coarse = is_light && look.surface.is_some_and(|surface| surface.is_moving);
        let step = if is_shaded || is_coarse { COARSE_STEP } else { 1 };
        let size = (picture.0.div_ceil(step), picture.1.div_ceil(step));
        let is_wave = view.quantity == Quantity::Instantaneous;
        let veil = view.veil().filter(|_| look.is_veil);
        let quantity = if veil.is_some() { Quantity::Rms } else { view.quantity };
        let request = Request {
            aperture: sound.aperture.clone(),
            plane: view.plane(scene, lens),
            moment: if is_wave { look.moment * TAU } else { 0.0 },
            channel: view.channel,
            size,
            ..self.requested(scene, &look.drives, quantity)
        };
        let (request, range) = match look.surface {
            Some(surface) => (waves::at(&request, surface.depth.clone()), Some(surface.range)),
            None => (request, None),
        };
        let full = look.full.or(view.full).or(range.map(|[_, high]| high)).map(|full| full as f32);
        let low = view.low.filter(|_| view.full.is_some()).or(range.map(|[low, _]| low));
        let low = low.map(|low| low as f32);
        let colouring = veil.unwrap_or_else(|| Colouring { full, low, ..view.colouring() });
        let contours = view.contour_levels().to_vec();
        let deepest = range.map(|[low, high]| high.max(-low));
        let automatic = deepest.map(|deepest| relief::exaggeration(deepest, request.plane.size));
        let exaggeration = view.relief.exaggeration.or(automatic);
        let relief = is_shaded.then_some(relief::Look { exaggeration, ..view.relief });
        Some(Wanted { request, colouring, picture, relief, contours })
    }

    /// The request of a scene's map, of any size.
    fn requested(&mut self, scene: &Scene, drives: &[Drive], quantity: Quantity) -> Request {
        let request = || Request::new(scene, drives.to_vec(), quantity, (1, 1));
        if !quantity.declaration().of_skin || scene.array.response.is_none() {
            return request();
        }
        let is_kept =
            |kept: &Responding| kept.quantity == quantity && kept.drives == drives && kept.scene == *scene;
        match self.responding.as_deref().filter(|kept| is_kept(kept)) {
            Some(kept) => kept.request.clone(),
            None => {
                let request = request();
                let (scene, drives) = (scene.clone(), drives.to_vec());
                let kept = Responding { scene, drives, quantity, request: request.clone() };
                self.responding = Some(Box::new(kept));
                request
            }
        }
    }

    /// Makes the picture of a slow map from the values that are there; the previous one stays until then. A map being made
    /// is displayed before the next is begun: otherwise a drag, with a new request per frame, would never display any.
    fn await_slow(
        &mut self,
        wanted: Wanted,
        frame: Frame,
        map: &mut Option<Map>,
        done: &mut Done,
        ctx: &Context,
    ) -> Result<(), FieldError> {
        let this = Box::new(Awaited { wanted, frame, asked: Instant::now() });
        let before = self.awaited.take().filter(|before| is_slow(&before.wanted.request));
        let (first, is_outdated) = match before {
            Some(before) if before.wanted != this.wanted && self.slow.is_running() => (before, true),
            Some(before) if before.wanted == this.wanted => (before, false),
            Some(_) | None => (this.clone(), false),
        };
        let found = self.slow.get(&first.wanted.request).map(|found| found.cloned());
        if let Some((request, values)) = found.transpose()? {
            let Awaited { mut wanted, frame, asked } = (*first).clone();
            wanted.request = request;
            if self.drawn.as_ref().is_none_or(|drawn| drawn.wanted != wanted) {
                self.stages.keep(&wanted.request, values)?;
                self.make(wanted.clone(), (frame, asked), map, done, ctx)?;
            }
            if wanted == this.wanted {
                return Ok(());
            }
            if is_outdated {
                self.slow.stop();
            }
        } else if is_outdated && first.wanted.request.quantity.declaration().of_volume {
            self.slow.stop();
        }
        let next = if is_outdated && self.slow.is_running() { first } else { this };
        self.slow.begin(&next.wanted.request, ctx);
        self.awaited = self.slow.is_running().then_some(next);
        Ok(())
    }

    /// Makes the picture of values read back from a GPU once available, without blocking; the previous one stays
    /// until then. Requests are displayed in order: otherwise a drag, with a new request per frame, would never
    /// display any.
    fn await_values(
        &mut self,
        wanted: Wanted,
        frame: Frame,
        map: &mut Option<Map>,
        done: &mut Done,
        ctx: &Context,
    ) -> Result<(), FieldError> {
        let (before, asked) = match self.awaited.take() {
            Some(this) if this.wanted == wanted => (None, this.asked),
            before => (before, Instant::now()),
        };
        let this = Box::new(Awaited { wanted, frame, asked });
        for awaited in before.into_iter().chain([this]) {
            if self.stages.poll(&awaited.wanted.request)?.is_none() {
                self.awaited = Some(awaited);
                break;
            }
            let Awaited { wanted, frame, asked } = *awaited;
            self.make(wanted, (frame, asked), map, done, ctx)?;
        }
        Ok(())
    }

    /// Remakes the picture.
    fn make(
        &mut self,
        wanted: Wanted,
        (frame, start): (Frame, Instant),
        map: &mut Option<Map>,
        done: &mut Done,
        ctx: &Context,
    ) -> Result<(), FieldError> {
        let (width, height) = wanted.picture;
        let request = &wanted.request;
        let mut drawn = None;
        let mut exaggeration = None;
        let before = map.take();
        let (known, old) = before.map_or(((0.0, 0.0, String::new()), None), |map| {
            ((map.largest, map.error, map.how), Some(map.texture))
        });
        let texture = if let Some(look) = wanted.relief {
            let values = &self.stages.map(request)?.values;
            let mut surface = Relief::new(values, request.size.0, request.plane.size);
            (surface.sight, surface.exaggeration) =
                (look.sight, look.exaggeration.unwrap_or(surface.exaggeration));
            let ground = theme::ground(false);
            let place = Place::on_screen(width, height, [ground.r(), ground.g(), ground.b()]);
            let per_metre = surface.sinks_in(&place) / f64::from(ctx.pixels_per_point());
            exaggeration = Some((surface.exaggeration, per_metre));
            let picture = surface.draw(&place);
            let image = from_top(&picture);
            drawn = Some(picture);
            in_egui(old, image, NEAREST, ctx)
        } else {
            let Self { stages, screen, registered, .. } = self;
            let size = [request.size.0, request.size.1];
            // Until the whole map is there, one of fewer pixels is blurred.
            let filter = if request.size == wanted.picture { NEAREST } else { TextureOptions::LINEAR };
            let by_cpu = |colours: &[_]| in_egui(old, image(size, colours), filter, ctx);
            match screen {
                None => by_cpu(stages.colours(request, &wanted.colouring)?),
                Some(screen) => match stages.picture(request, &wanted.colouring)? {
                    Painted::OnGpu(texture) => Texture::OnGpu(screen.register(registered, texture)),
                    Painted::OnCpu(colours) => by_cpu(colours),
                },
            }
        };
        *map = Some(Map {
            texture,
            cut: frame.cut,
            axes: frame.axes,
            window: frame.lens.window,
            rect: frame.lens.rect,
            veil: None,
            full: wanted.colouring.full.map(f64::from),
            low: wanted.colouring.low.map(f64::from),
            quantity: request.quantity,
            phase: request.moment,
            // Those of the previous map until the GPU's results arrive.
            largest: known.0,
            remark: None,
            error: known.1,
            how: known.2,
            width: request.size.0,
            height: request.size.1,
            contours: Vec::new(),
            exaggeration: exaggeration.map(|(times, _)| times),
            per_depth: exaggeration.map_or(0.0, |(_, per_metre)| per_metre),
            numbers: None,
        });
        let lacks_contours = !wanted.contours.is_empty();
        self.drawn = Some(Drawn { wanted, picture: drawn, lacks_figures: true, lacks_contours });
        self.complete(map, done)?;
        done.milliseconds = Some(start.elapsed().as_secs_f64() * 1e3);
        Ok(())
    }

    /// Adds missing parts.
    fn complete(&mut self, map: &mut Option<Map>, done: &mut Done) -> Result<(), FieldError> {
        let Self { stages, drawn, .. } = self;
        let (Some(drawn), Some(map)) = (drawn, map) else { return Ok(()) };
        let Wanted { request, contours, .. } = &drawn.wanted;
        if drawn.lacks_figures
            && let Some((figures, seconds)) = stages.figures(request)?
        {
            map.remark = map::remark(request.quantity, &figures);
            (map.largest, map.error, map.how) = (figures.peak.into(), figures.error, figures.how);
            done.on_gpu = Some(seconds.map(|seconds| seconds * 1e3));
            // If one pressure determines the value, panels derive it from the sound.
            let is_known =
                request.quantity.declaration().parts == PRESSURE && request.aperture.bodies.is_empty();
            let has_values = figures.by != crate::field::By::Gpu;
            if has_values && !is_known {
                map.numbers = Some(stages.map(request)?.values.clone());
            }
            drawn.lacks_figures = false;
        } else if drawn.lacks_figures && stages.has_declined(request) {
            // The GPU does not keep the tolerance: the CPU computes the next frame.
            self.drawn = None;
            return Ok(());
        }
        if drawn.lacks_contours
            && let Some(values) = stages.poll(request)?
        {
            let largest = f64::from(values.peak);
            for level in contours {
                let part = map::contour(request.quantity, *level, largest) / largest;
                map.contours.extend_from_slice(stages.contours(request, part as f32)?);
            }
            drawn.lacks_contours = false;
        }
        Ok(())
    }

    /// Repeats work on the CPU if the GPU fails.
    fn or_by_cpu<T>(&mut self, work: impl Fn(&mut Self) -> Result<T, FieldError>) -> Result<T, FieldError> {
        match work(self) {
            Err(FieldError::Gpu(error)) => {
                self.give_up_gpu(error);
                work(self)
            }
            done => done,
        }
    }

    fn give_up_gpu(&mut self, error: GpuError) {
        self.has_lost_screen = self.screen.is_some() && matches!(error, GpuError::Lost(_));
        self.stages = Stages::new(Evaluator::Cpu);
        self.slow = SlowMaps::new(None);
        self.given_up = Some(error);
        (self.drawn, self.awaited) = (None, None);
    }

    /// The map on the screen as a picture. Waits for a GPU.
    pub fn picture(&mut self) -> Option<Picture> {
        let Drawn { wanted, picture, .. } = self.drawn.as_ref()?;
        if picture.is_some() {
            return picture.clone();
        }
        let Wanted { request, colouring, .. } = wanted.clone();
        let colours =
            self.or_by_cpu(|own| own.stages.colours(&request, &colouring).map(<[_]>::to_vec)).ok()?;
        let mut picture = Picture::from_field_order(request.size.0, request.size.1, colours.as_flattened());
        if let Some(veil) = self.veil.as_mut().and_then(|veil| veil.mapping.picture()) {
            picture.veil(&veil);
        }
        Some(picture)
    }

    /// The map's values, height and width first. Waits for a GPU.
    pub fn numbers(&mut self) -> Option<(Vec<u64>, Vec<f32>)> {
        let request = self.drawn.as_ref()?.wanted.request.clone();
        let values =
            self.or_by_cpu(|own| own.stages.map(&request).map(|map: &Values| map.values.clone())).ok()?;
        Some((vec![request.size.1 as u64, request.size.0 as u64], values))
    }
}

/// A picture with its lowest row first, as maps are.
fn from_top(picture: &Picture) -> ColorImage {
    let mut pixels = Vec::with_capacity(picture.width * picture.height);
    for row in picture.rgba.chunks_exact(picture.width * 4).rev() {
        pixels.extend(row.as_chunks::<4>().0.iter().map(|&[r, g, b, _]| Color32::from_rgb(r, g, b)));
    }
    ColorImage::new([picture.width, picture.height], pixels)
}

pub fn image(size: [usize; 2], colours: &[[u8; 4]]) -> ColorImage {
    ColorImage::from_rgba_premultiplied(size, colours.as_flattened())
}

/// The image as an egui texture, replacing that of the previous map.
pub fn in_egui(
    before: Option<Texture>,
    image: ColorImage,
    options: TextureOptions,
    ctx: &Context,
) -> Texture {
    match before {
        Some(Texture::InEgui(mut texture)) => {
            texture.set(image, options);
            Texture::InEgui(texture)
        }
        Some(Texture::OnGpu(_)) | None => Texture::InEgui(ctx.load_texture("map", image, options)),
    }
}
