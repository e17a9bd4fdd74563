//! The map on the screen: what it is made from, and the stages that make it again when that differs.

use std::f64::consts::{SQRT_2, TAU};
use std::time::Instant;

use egui::{Color32, ColorImage, Context, TextureOptions};

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::contour::Line;
use crate::field::{
    Average, Colouring, Evaluator, FieldError, Gpu, GpuError, Mean, Quantity, Stages, Wanted, Work,
};
use crate::picture::Picture;
use crate::picture::relief::{Place, Relief};
use crate::scene::Plane;
use crate::studio::{liquid, map};
use crate::ui::canvas::GROUND;
use crate::ui::view::Lens;
use crate::ui::{Editor, Map, Notice, Pressed, Shown, Texture};

/// Pixels of a map, at most.
const MOST_PIXELS: usize = 1 << 23;
/// Pixels from one point of a shaded surface to the next.
const SHADED_STEP: usize = 2;
/// Parts of the picture's height that are kept free around a shaded surface.
const SHADED_SIDE: f64 = 0.04;
const SHADED_TOP: f64 = 0.09;
const SHADED_BOTTOM: f64 = 0.12;

/// Everything that a map is made from.
#[derive(Clone, Debug, PartialEq)]
struct Request {
    aperture: Aperture,
    plane: Plane,
    /// Played one after the other; a field is that of the first.
    drives: Vec<Drive>,
    mean: Option<Mean>,
    part: f64,
    /// Pixels of the picture.
    picture: (usize, usize),
    /// Pixels of the numbers: fewer where they are shaded.
    size: (usize, usize),
    colouring: Colouring,
    is_shaded: bool,
    /// Where contour lines are, as a part of the largest number.
    contour: Option<f64>,
}

#[derive(Debug)]
pub struct Mapping {
    stages: Stages,
    /// What the map on the screen was made from, and the picture of a surface that is shaded.
    drawn: Option<(Request, Option<Picture>)>,
    /// Why the GPU does not compute any more, until the window has said so.
    given_up: Option<GpuError>,
}

/// What is known of a map besides its colours.
struct Figures {
    largest: f64,
    error: f64,
    how: String,
    numbers: Option<Vec<f32>>,
    pressed: Option<Pressed>,
}

impl Mapping {
    pub fn new(evaluator: Evaluator) -> Self {
        Self { stages: Stages::new(evaluator), drawn: None, given_up: None }
    }

    /// Who computes the field.
    pub fn evaluator(&self) -> String {
        let cpu = || format!("CPU, {}", crate::simd::Isa::best().name());
        self.stages.gpu().map_or_else(cpu, |gpu| gpu.info().name.clone())
    }

    /// The GPU that computes the field, if one does.
    pub fn gpu(&self) -> Option<&Gpu> {
        self.stages.gpu()
    }

    /// How often each stage of the field has run.
    pub fn work(&self) -> Work {
        self.stages.work()
    }

    /// Brings the map up to date.
    pub fn update(&mut self, editor: &Editor, shown: &mut Shown, lens: &Lens, ctx: &Context) {
        if let Some(error) = self.given_up.take() {
            shown.evaluator = self.evaluator();
            let text = format!("{error}; the CPU computes the field from now on");
            shown.notice = Some(Notice { text, is_error: true });
        }
        let Some(request) = request(editor, shown, lens, ctx) else {
            shown.map = None;
            shown.pressed = None;
            self.drawn = None;
            return;
        };
        if self.drawn.as_ref().is_some_and(|(drawn, _)| *drawn == request) {
            return;
        }
        let start = Instant::now();
        match self.make(&request, editor, shown, lens, ctx) {
            Ok(picture) => {
                shown.mapping = start.elapsed().as_secs_f64() * 1e3;
                self.drawn = Some((request, picture));
            }
            Err(FieldError::Gpu(error)) => {
                self.give_up_gpu(error);
                ctx.request_repaint();
            }
            Err(error) => {
                shown.problem.get_or_insert(error.to_string());
            }
        }
    }

    /// Makes the map anew; the picture comes back where it is not made of the numbers' colours.
    fn make(
        &mut self,
        request: &Request,
        editor: &Editor,
        shown: &mut Shown,
        lens: &Lens,
        ctx: &Context,
    ) -> Result<Option<Picture>, FieldError> {
        let Figures { largest, error, how, numbers, pressed } = self.figures(request)?;
        let contours = self.contours(request)?;
        let (width, height) = request.picture;
        let relief = request.relief(numbers.as_deref());
        let picture = relief.map(|relief| relief.draw(&place(width, height)));
        let image = match &picture {
            Some(picture) => from_top(picture),
            None => {
                let colours = self.colours(request)?;
                ColorImage::from_rgba_premultiplied([width, height], colours.as_flattened())
            }
        };
        shown.pressed = pressed;
        shown.map = Some(Map {
            texture: texture(shown.map.take(), image, ctx),
            cut: editor.view.cut,
            axes: editor.view.axes(editor.scene()),
            window: lens.window,
            rect: lens.rect,
            quantity: request.colouring.quantity,
            phase: request.colouring.phase.into(),
            largest,
            error,
            how,
            width: request.size.0,
            height: request.size.1,
            contours,
            exaggeration: relief.map(|relief| relief.exaggeration()),
            numbers,
        });
        Ok(picture)
    }

    fn figures(&mut self, request: &Request) -> Result<Figures, FieldError> {
        let Some(average) = request.average() else {
            let map = self.stages.map(&request.wanted())?;
            let peak = f64::from(map.peak);
            let is_peak = request.colouring.quantity == Quantity::Instantaneous;
            let largest = if is_peak { peak } else { peak / SQRT_2 };
            return Ok(Figures {
                largest,
                error: map.error,
                how: map.how.clone(),
                numbers: None,
                pressed: None,
            });
        };
        let map = self.stages.average(&average)?.clone();
        let beyond = map.dent.as_ref().and_then(|dent| liquid::beyond_linear_theory(dent.slope));
        Ok(Figures {
            largest: map.largest.into(),
            error: map.error,
            how: map.how,
            numbers: Some(self.stages.read_average(&average)?),
            pressed: Some(Pressed { force: map.force, dent: map.dent, beyond }),
        })
    }

    fn contours(&mut self, request: &Request) -> Result<Vec<Line>, FieldError> {
        let Some(part) = request.contour else { return Ok(Vec::new()) };
        let lines = match request.average() {
            None => self.stages.contours(&request.wanted(), request.colouring.quantity, part as f32)?,
            Some(average) => self.stages.average_contours(&average, part as f32)?,
        };
        Ok(lines.to_vec())
    }

    fn colours(&mut self, request: &Request) -> Result<&[[u8; 4]], FieldError> {
        match request.average() {
            None => self.stages.colours(&request.wanted(), &request.colouring),
            Some(average) => self.stages.average_colours(&average, &request.colouring),
        }
    }

    /// Does something again by the CPU where the GPU fails.
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
        self.stages = Stages::new(Evaluator::Cpu);
        self.given_up = Some(error);
    }

    /// The map on the screen as a picture.
    pub fn picture(&mut self) -> Option<Picture> {
        let (request, picture) = self.drawn.clone()?;
        if picture.is_some() {
            return picture;
        }
        let colours = self.or_by_cpu(|own| own.colours(&request).map(<[_]>::to_vec)).ok()?;
        Some(Picture::from_field_order(request.size.0, request.size.1, colours.as_flattened()))
    }

    /// The map's numbers, height and width first.
    pub fn numbers(&mut self) -> Option<(Vec<u64>, Vec<f32>)> {
        let request = self.drawn.as_ref()?.0.clone();
        let values = self.or_by_cpu(|own| match request.average() {
            Some(average) => own.stages.read_average(&average),
            None => {
                let field = own.stages.read(&request.wanted())?;
                Ok(field.iter().map(|&p| request.colouring.of(p)).collect())
            }
        });
        let values = values.ok()?;
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

    /// The surface that these depths make, if it is to be shaded.
    fn relief<'a>(&self, depth: Option<&'a [f32]>) -> Option<Relief<'a>> {
        let depth = depth.filter(|_| self.is_shaded)?;
        Some(Relief { depth, columns: self.size.0, size: self.plane.size })
    }
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
    let picture = (pixels(lens.rect.width()), pixels(lens.rect.height()));
    if picture.0 * picture.1 > MOST_PIXELS {
        return None;
    }
    let is_shaded = view.is_shaded();
    let step = if is_shaded { SHADED_STEP } else { 1 };
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
    let is_wave = view.quantity == Quantity::Instantaneous;
    let phase = if is_wave { (editor.oscillation.part * TAU) as f32 } else { 0.0 };
    Some(Request {
        aperture: sound.aperture.clone(),
        plane: view.plane(scene, lens),
        drives,
        part: if mean.is_some() { scene.modulation.mean_square() } else { 1.0 },
        mean,
        picture,
        size: (picture.0.div_ceil(step), picture.1.div_ceil(step)),
        colouring: Colouring { full, phase, ..view.colouring() },
        is_shaded,
        contour: view.contour_part(),
    })
}

/// Where on the canvas a shaded surface is.
fn place(width: usize, height: usize) -> Place {
    let high = height as f64;
    Place {
        width,
        height,
        side: SHADED_SIDE * high,
        top: SHADED_TOP * high,
        bottom: SHADED_BOTTOM * high,
        ground: [GROUND.r(), GROUND.g(), GROUND.b()],
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

/// The image as a texture, in place of that of the map before.
fn texture(before: Option<Map>, image: ColorImage, ctx: &Context) -> Texture {
    let options = TextureOptions { magnification: egui::TextureFilter::Nearest, ..TextureOptions::LINEAR };
    match before {
        Some(mut map) => {
            map.texture.0.set(image, options);
            map.texture
        }
        None => Texture(ctx.load_texture("map", image, options)),
    }
}
