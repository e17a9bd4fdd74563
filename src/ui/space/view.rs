//! How space is looked at, and what is held there.

use egui::Rect;
use glam::{DVec2, DVec3};
use strum::{IntoStaticStr, VariantArray};

use crate::field::volume::camera::{Projection, Standard};
use crate::field::volume::scenery::Body;
use crate::field::volume::{Block, Camera};
use crate::scene::{Array, Board, Plane, Scene, Target};
use crate::studio::space::{Look, block_of, surface_part, whole};
use crate::ui::map::Texture;
use crate::ui::sound::Sound;
use crate::ui::view::View;

/// The representation of the field in the box, apart from slices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(const_into_str)]
pub enum Seen {
    Surface,
    Projection,
    Slices,
}

impl Seen {
    pub(super) fn tooltip(self) -> &'static str {
        match self {
            Self::Surface => "The isosurface of RMS pressure at this level below its peak",
            Self::Projection => "The largest RMS pressure along every line of sight",
            Self::Slices => "Slices alone",
        }
    }
}

/// The state of the 3D view; not part of the scene.
#[derive(Clone, Debug)]
pub struct SpaceView {
    pub is_on: bool,
    /// `None`: the whole box from [`SpaceView::direction`].
    pub camera: Option<Camera>,
    /// Azimuth and elevation, rad.
    pub direction: [f64; 2],
    pub is_perspective: bool,
    pub seen: Seen,
    /// dB of the peak.
    pub level: f64,
    /// Positions of slices across x, y and z, m.
    pub slices: [Option<f64>; 3],
    /// The field on the scene's plane.
    pub has_plane: bool,
    pub is_clipped: bool,
    /// Corners of the clipping box, as fractions of the box.
    pub clip: [DVec3; 2],
    framed: Option<Framed>,
    pub(super) held: Option<Held>,
    /// It was there on the last frame, too.
    pub(super) was_on: bool,
}

impl Default for SpaceView {
    fn default() -> Self {
        Self {
            is_on: false,
            camera: None,
            direction: Standard::Iso.direction(),
            is_perspective: true,
            seen: Seen::Surface,
            level: -6.0,
            slices: [None; 3],
            has_plane: true,
            is_clipped: false,
            clip: [DVec3::ZERO, DVec3::ONE],
            framed: None,
            held: None,
            was_on: false,
        }
    }
}

/// The displayed box, and the part of a scene behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Framed {
    block: Block,
    /// The boards as well.
    whole: Block,
    plane: Plane,
    array: Array,
    boards: Vec<Board>,
}

/// Draggable handles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Handle {
    /// Along an axis.
    Axis(usize),
    /// Across an axis.
    Plane(usize),
    Slice(usize),
    /// A face of the clipping box: its axis, and whether it is the upper one.
    Face(usize, bool),
}

/// The object of a drag.
#[derive(Clone, Debug)]
pub enum Held {
    Orbit,
    Pan,
    /// Grabbed point (m), and the targets, or the body with its place, before.
    Targets {
        handle: Handle,
        from: DVec3,
        before: Vec<(usize, Target)>,
        body: Option<(usize, DVec3)>,
    },
    /// Offset of the grabbed point from the handle along its axis, m.
    Slide {
        handle: Handle,
        off: f64,
    },
}

/// The 3D view on this frame.
#[derive(Clone, Debug)]
pub struct Stage {
    /// Points of the screen.
    pub rect: Rect,
    pub camera: Camera,
    pub block: Block,
    pub clip: Block,
    /// Something is dragged: soon is better than fine.
    pub is_moving: bool,
    /// m in steps of a handle that the pointer is over.
    pub(super) over: Option<Handle>,
}

impl Stage {
    /// In points of the screen, from the rectangle's corner.
    pub fn projection(&self) -> Projection {
        let size = self.rect.size();
        self.camera.projection(DVec2::new(size.x.into(), size.y.into()))
    }

    /// Where a point (m) is seen.
    pub fn screen(&self, point: DVec3) -> Option<egui::Pos2> {
        let (at, _) = self.projection().screen(point)?;
        Some(self.rect.min + egui::vec2(at.x as f32, at.y as f32))
    }

    /// Origin and direction of the ray under a screen position.
    pub(super) fn ray(&self, at: egui::Pos2) -> (DVec3, DVec3) {
        let offset = at - self.rect.min;
        self.projection().ray(DVec2::new(offset.x.into(), offset.y.into()))
    }

    /// m per point of the screen at a position.
    pub(super) fn per_point(&self, point: DVec3) -> f64 {
        let projection = self.projection();
        projection.screen(point).map_or(0.0, |(_, depth)| projection.per_pixel(depth))
    }
}

/// A picture of space on the screen.
#[derive(Debug)]
pub struct SpaceShown {
    pub texture: Texture,
    /// The view that it was made for.
    pub stage: Stage,
    /// Pa RMS: the largest value in the box.
    pub peak: f64,
    /// The field lacks what bodies scatter.
    pub is_incident: bool,
    /// A finer one is on its way.
    pub is_coarse: bool,
    /// Times of the picture and, if recomputed, its field, ms.
    pub milliseconds: [f64; 2],
}

impl SpaceView {
    /// Resets the camera to the whole box.
    pub fn go_home(&mut self) {
        (self.camera, self.direction) = (None, Standard::Iso.direction());
    }

    /// All of the box from a standard view.
    pub fn look_from(&mut self, standard: Standard) {
        (self.camera, self.direction) = (None, standard.direction());
    }

    /// Another view is looked at.
    pub fn leave(&mut self) {
        (self.was_on, self.held) = (false, None);
    }

    /// Whether a drag is in progress.
    pub fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// Ends a drag, and returns whether it was an edit.
    pub fn let_go(&mut self) -> bool {
        matches!(self.held.take(), Some(Held::Targets { .. }))
    }

    /// The visible part of the box.
    pub(super) fn clipped(&self, block: &Block) -> Block {
        if !self.is_clipped {
            return *block;
        }
        let [low, high] = self.clip.map(|part| block.low() + block.size * part);
        Block::between(low, high)
    }

    pub fn body(&self) -> Body {
        match self.seen {
            Seen::Surface => Body::Surface(surface_part(self.level)),
            Seen::Projection => Body::Projection,
            Seen::Slices => Body::Hidden,
        }
    }

    /// The displayed objects, in the colours of the view.
    pub fn look(&self, view: &View, scale: f64) -> Look {
        Look {
            body: self.body(),
            slices: self.slices,
            has_plane: self.has_plane,
            has_targets: view.marks,
            has_elements: true,
            has_box: true,
            colours: view.colours,
            is_light: view.is_light,
            scale,
        }
    }

    /// The box of a scene, and what is around all of it. It is kept while targets move within it, so that the view
    /// does not shift under the pointer.
    pub(super) fn frame(&mut self, scene: &Scene, sound: Option<&Sound>, is_held: bool) -> [Block; 2] {
        /// Limit of its size relative to the required one.
        const MOST_FREE: f64 = 3.0;
        let Some(sound) = sound else {
            let usual = Block { centre: DVec3::Z * 0.1, size: DVec3::splat(0.2) };
            return self.framed.as_ref().map_or([usual; 2], |framed| [framed.block, framed.whole]);
        };
        let block = block_of(scene, &sound.aperture, &sound.foci);
        let fresh = Framed {
            block,
            whole: whole(&block, &sound.aperture),
            plane: scene.plane.clone(),
            array: scene.array.clone(),
            boards: scene.boards.clone(),
        };
        if let Some(framed) = &self.framed {
            let is_same = Framed { block, whole: fresh.whole, ..framed.clone() } == fresh;
            let (own, wanted) = (framed.block, fresh.block);
            let holds =
                own.low().cmple(wanted.low() + 1e-9).all() && own.high().cmpge(wanted.high() - 1e-9).all();
            let is_close = own.size.element_product() <= MOST_FREE * wanted.size.element_product();
            if is_held || (is_same && holds && is_close) {
                return [own, framed.whole];
            }
        }
        let framed = self.framed.insert(fresh);
        [framed.block, framed.whole]
    }
}
