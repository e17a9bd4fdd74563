//! The picture of the 3D view: coarse while something moves, fine at rest.
//!
//! The first picture by the CPU has 66 000 pixels of a field with four samples per wavelength; the fine one is
//! drawn on a thread once nothing moves. A GPU draws full pictures, and only the field is refined at rest.

use std::sync::Arc;

use egui::{ColorImage, Context, TextureId, TextureOptions};
use glam::DVec2;
use web_time::Instant;

use crate::acoustics::Aperture;
use crate::app::mapping::Mapping;
use crate::app::screen::Screen;
use crate::drive::Drive;
use crate::field::gpu::{SpacePainting, Texture as OnGpu};
use crate::field::volume::scenery::{Item, Shot};
use crate::field::volume::{Block, Camera, Fineness, Scenery, Volume, march};
use crate::field::{Gpu, GpuError};
use crate::gauge::Gauge;
use crate::picture::Picture;
use crate::studio::later::Later;
use crate::studio::space::{self, Prospect};
use crate::ui::bodies;
use crate::ui::part::wake;
use crate::ui::space::{SpaceShown, Stage};
use crate::ui::{Editor, Shown, Texture};

/// Pixels of a picture by the CPU while something moves, and of any picture, at most.
const SOON: f64 = 66_000.0;
const MOST: f64 = 4_000_000.0;

/// The inputs of a field in space.
#[derive(Clone, Debug, PartialEq)]
struct Sounding {
    aperture: Aperture,
    drives: Vec<Drive>,
    block: Block,
}

impl Sounding {
    fn volume(&self, is_dragged: bool) -> Arc<Volume> {
        Arc::new(Volume::new(&self.aperture, &self.drives, &self.block, Fineness::of(is_dragged)))
    }
}

/// The inputs of a picture.
#[derive(Clone, Debug, PartialEq)]
struct Wanted {
    sounding: Sounding,
    scenery: Scenery,
    camera: Camera,
    size: (usize, usize),
}

impl Wanted {
    fn draw(&self, volume: &Volume, is_smooth: bool) -> Vec<u8> {
        let shot = Shot::new(&self.scenery, volume, &self.camera, self.size);
        march::picture(&shot, volume, &self.scenery.table, is_smooth)
    }
}

/// A picture from a thread.
#[derive(Debug)]
struct Drawing {
    volume: Arc<Volume>,
    rgba: Vec<u8>,
    /// ms for the field and for the picture.
    milliseconds: [f64; 2],
}

/// A field and its inputs.
type Kept = Option<(Sounding, Arc<Volume>)>;

#[derive(Debug, Default)]
pub struct Spacing {
    coarse: Kept,
    fine: Kept,
    pictures: Later<Wanted, Drawing>,
    fields: Later<Sounding, Arc<Volume>>,
    skins: Later<(Aperture, Vec<Drive>), Arc<Vec<Item>>>,
    /// The displayed picture, and whether it is coarse.
    drawn: Option<(Wanted, bool)>,
    painting: SpacePainting,
    registered: Option<(OnGpu, TextureId)>,
}

impl Spacing {
    pub fn is_running(&self) -> bool {
        self.pictures.is_running() || self.fields.is_running() || self.skins.is_running()
    }

    /// Collects finished values, and returns whether there were any.
    pub fn collect(&mut self) -> bool {
        let came = [self.pictures.collect(), self.fields.collect(), self.skins.collect()];
        came.contains(&true)
    }

    /// The picture on the screen, as fine as it gets.
    pub fn picture(&self, editor: &Editor, shown: &Shown) -> Option<Picture> {
        let (wanted, _) = self.drawn.as_ref()?;
        Some(self.prospect(editor, shown, editor.view.is_light)?.draw(wanted.size).0)
    }

    /// The displayed view, for a picture of any size on this ground.
    pub fn prospect(&self, editor: &Editor, shown: &Shown, is_light: bool) -> Option<Prospect> {
        let (Wanted { sounding, scenery, camera, .. }, _) = self.drawn.as_ref()?;
        let (sound, size) = (shown.sound.as_ref()?, shown.space.as_ref()?.stage.rect.size());
        let fine = self.fine.as_ref().filter(|(of, _)| of == sounding);
        Some(Prospect {
            scene: Arc::new(editor.scene().clone()),
            aperture: sounding.aperture.clone(),
            drive: sound.drive().clone(),
            heard: sounding.drives.clone(),
            foci: sound.foci.clone(),
            block: sounding.block,
            clip: scenery.clip,
            camera: *camera,
            look: space::Look { is_light, ..editor.space.look(&editor.view, 1.0) },
            points: DVec2::new(size.x.into(), size.y.into()),
            volume: fine.map(|(_, volume)| Arc::clone(volume)),
            skins: self.skins.get(&(sounding.aperture.clone(), sounding.drives.clone())).cloned(),
        })
    }

    /// Releases everything while the 3D view is closed.
    pub fn rest(&mut self, shown: &mut Shown) {
        if self.drawn.take().is_some() {
            (self.coarse, self.fine, shown.space) = (None, None, None);
        }
    }

    /// Brings the picture up to date.
    pub fn update(
        &mut self,
        editor: &Editor,
        shown: &mut Shown,
        stage: &Stage,
        mapping: &Mapping,
        ctx: &Context,
    ) -> Result<(), GpuError> {
        let sound = shown.sound.as_ref();
        let Some(sound) = sound.filter(|sound| sound.drive().phases.len() == sound.aperture.positions.len())
        else {
            (self.drawn, shown.space) = (None, None);
            return Ok(());
        };
        let sounding =
            Sounding { aperture: sound.aperture.clone(), drives: sound.heard.clone(), block: stage.block };
        let skins = self.skins(editor, &sounding, ctx);
        let wanted = |most: f64| {
            let points = stage.rect.size();
            let scale = f64::from(ctx.pixels_per_point());
            let pixels = f64::from(points.x * points.y) * scale * scale;
            let scale = scale * (most / pixels.max(1.0)).sqrt().min(1.0);
            let side = |points: f32| ((f64::from(points) * scale).round() as usize).max(1);
            let look = editor.space.look(&editor.view, scale);
            let scenery = space::scenery(
                editor.scene(),
                (&sound.aperture, sound.drive()),
                &sound.foci,
                (&stage.block, &stage.clip),
                &skins,
                &look,
            );
            let size = (side(points.x), side(points.y));
            Wanted { sounding: sounding.clone(), scenery, camera: stage.camera, size }
        };
        let is_still = !stage.is_moving && !ctx.input(|input| input.pointer.any_down());
        let best = wanted(MOST);
        let gpu = mapping.gpu().filter(|gpu| gpu.draws_space());
        if let (Some(gpu), Some(screen)) = (gpu, mapping.screen()) {
            return self.by_gpu((gpu, screen), best, (stage, is_still), shown, ctx);
        }
        if self.drawn.as_ref().is_some_and(|(drawn, is_coarse)| !is_coarse && *drawn == best) {
            return Ok(());
        }
        if let Some(Drawing { volume, rgba, milliseconds }) = self.pictures.get(&best) {
            put(shown, rgba, best.size, stage, ctx);
            tell(shown, volume, false, *milliseconds);
            self.fine = Some((sounding, Arc::clone(volume)));
            self.drawn = Some((best, false));
            return Ok(());
        }
        if let Some(volume) = self.fields.get(&sounding) {
            self.fine = Some((sounding.clone(), Arc::clone(volume)));
        }
        let soon = wanted(SOON);
        if self.drawn.as_ref().is_none_or(|(drawn, is_coarse)| !(*is_coarse && *drawn == soon)) {
            let start = Instant::now();
            let volume = self.volume(&sounding);
            let sampled = start.elapsed().as_secs_f64() * 1e3;
            let rgba = soon.draw(&volume, false);
            put(shown, &rgba, soon.size, stage, ctx);
            tell(shown, &volume, true, [sampled, start.elapsed().as_secs_f64() * 1e3 - sampled]);
            self.drawn = Some((soon, true));
        }
        let known = self.fine.clone().filter(|(of, _)| *of == sounding).map(|(_, volume)| volume);
        let waits = known.is_none() && !sounding.aperture.bodies.is_empty();
        if is_still && waits {
            // It takes long enough for several pictures.
            self.refine(&sounding, ctx);
        } else if is_still {
            self.pictures.ask(&best, wake(ctx), move |wanted| {
                let start = Instant::now();
                let volume = known.unwrap_or_else(|| wanted.sounding.volume(false));
                let sampled = start.elapsed().as_secs_f64() * 1e3;
                let rgba = wanted.draw(&volume, true);
                let drawn = start.elapsed().as_secs_f64() * 1e3 - sampled;
                Drawing { volume, rgba, milliseconds: [sampled, drawn] }
            });
        }
        Ok(())
    }

    /// The surfaces of bodies: with the newest pressures on them, or grey until these are there.
    fn skins(&mut self, editor: &Editor, sounding: &Sounding, ctx: &Context) -> Arc<Vec<Item>> {
        if sounding.aperture.bodies.is_empty() {
            return Arc::default();
        }
        let key = (sounding.aperture.clone(), sounding.drives.clone());
        self.skins.ask(&key, wake(ctx), |(aperture, drives)| Arc::new(space::skins(aperture, drives)));
        if self.skins.latest().is_some_and(|(aperture, _)| *aperture == key.0)
            && let Some(newest) = self.skins.newest()
        {
            return Arc::clone(newest);
        }
        let grey = bodies::placed(editor).into_iter().flat_map(|mesh| space::facets(&mesh, None));
        Arc::new(grey.collect())
    }

    /// Requests the fine field.
    fn refine(&mut self, sounding: &Sounding, ctx: &Context) {
        self.fields.keep(Some(sounding));
        self.fields.ask_with(sounding, wake(ctx), |sounding, answer| {
            Gauge::default().until(&answer.cancel).lead(|| sounding.volume(false))
        });
    }

    /// The field immediately: the fine one if available, otherwise a coarse one.
    fn volume(&mut self, sounding: &Sounding) -> Arc<Volume> {
        if let Some((_, volume)) = self.fine.as_ref().filter(|(of, _)| of == sounding) {
            return Arc::clone(volume);
        }
        match &self.coarse {
            Some((of, volume)) if of == sounding => Arc::clone(volume),
            Some(_) | None => {
                let volume = sounding.volume(true);
                self.coarse = Some((sounding.clone(), Arc::clone(&volume)));
                volume
            }
        }
    }

    /// A GPU always draws full pictures; only the field is refined at rest.
    fn by_gpu(
        &mut self,
        (gpu, screen): (&Gpu, &Screen),
        wanted: Wanted,
        (stage, is_still): (&Stage, bool),
        shown: &mut Shown,
        ctx: &Context,
    ) -> Result<(), GpuError> {
        let sounding = &wanted.sounding;
        if let Some(volume) = self.fields.get(sounding) {
            self.fine = Some((sounding.clone(), Arc::clone(volume)));
        } else if is_still {
            self.refine(sounding, ctx);
        }
        let is_fine = self.fine.as_ref().is_some_and(|(of, _)| of == sounding);
        if self.drawn.as_ref().is_some_and(|(drawn, is_coarse)| *is_coarse != is_fine && *drawn == wanted) {
            return Ok(());
        }
        let start = Instant::now();
        let volume = self.volume(sounding);
        let sampled = start.elapsed().as_secs_f64() * 1e3;
        let shot = Shot::new(&wanted.scenery, &volume, &wanted.camera, wanted.size);
        let painted = self.painting.paint(gpu, (&shot, &wanted.scenery), &volume, true)?;
        let texture = Texture::OnGpu(screen.register(&mut self.registered, painted));
        let taken = start.elapsed().as_secs_f64() * 1e3 - sampled;
        shown.space = Some(blank(texture, stage));
        tell(shown, &volume, !is_fine, [sampled, taken]);
        self.drawn = Some((wanted, !is_fine));
        Ok(())
    }
}

/// Replaces the last picture's colours.
fn put(shown: &mut Shown, rgba: &[u8], (width, height): (usize, usize), stage: &Stage, ctx: &Context) {
    let image = ColorImage::from_rgba_premultiplied([width, height], rgba);
    let texture = match shown.space.take().map(|picture| picture.texture) {
        Some(Texture::InEgui(mut texture)) => {
            texture.set(image, TextureOptions::LINEAR);
            Texture::InEgui(texture)
        }
        Some(Texture::OnGpu(_)) | None => {
            Texture::InEgui(ctx.load_texture("space", image, TextureOptions::LINEAR))
        }
    };
    shown.space = Some(blank(texture, stage));
}

fn blank(texture: Texture, stage: &Stage) -> SpaceShown {
    let stage = stage.clone();
    SpaceShown { texture, stage, peak: 0.0, is_incident: false, is_coarse: false, milliseconds: [0.0; 2] }
}

fn tell(shown: &mut Shown, volume: &Volume, is_coarse: bool, milliseconds: [f64; 2]) {
    if let Some(picture) = &mut shown.space {
        (picture.peak, picture.is_incident) = (volume.peak.into(), volume.is_incident);
        (picture.is_coarse, picture.milliseconds) = (is_coarse, milliseconds);
    }
}
