//! The brush paints target pressure on a picture target; the eraser removes it.
//!
//! Painted pixels are ordinary values: a stroke copies the raster once per frame, and the history keeps one raster
//! per step.

use std::collections::BTreeSet;

use glam::DVec2;

use crate::scene::{Dab, Grey, Pixels, Scene, Target, outline};
use crate::ui::edit;
use crate::ui::editor::Editor;
use crate::ui::tool::{self, Brush};
use crate::ui::view::Axes;

/// m: a picture farther than this from the cut is not painted there.
const NEAR: f64 = 2e-3;

/// The picture painted by a stroke from a point of the plane: the selected one, or the topmost there.
pub fn picture_at(editor: &Editor, axes: &Axes, at: DVec2) -> Option<usize> {
    let targets = &editor.scene().targets;
    let has = |index: &usize| is_inside(&targets[*index], axes, at);
    selected(editor, axes).or_else(|| pictures_in(editor.scene(), axes).rev().find(has))
}

/// The single selected target, if it is a picture in the plane.
fn selected(editor: &Editor, axes: &Axes) -> Option<usize> {
    let only = editor.selection.first().filter(|_| editor.selection.len() == 1);
    only.copied().filter(|&index| editor.scene().targets.get(index).is_some_and(|target| is_in(target, axes)))
}

/// Paintable pictures in a plane, the topmost last.
fn pictures_in(scene: &Scene, axes: &Axes) -> impl DoubleEndedIterator<Item = usize> {
    (0..scene.targets.len()).filter(move |&index| is_in(&scene.targets[index], axes))
}

/// Whether a target is a visible, loaded picture in a plane.
pub fn is_in(target: &Target, axes: &Axes) -> bool {
    let is_loaded = target.shape.is_picture() && !target.lacks_pixels();
    let corners = || outline::strokes(target).unwrap_or_default().concat();
    target.visible && is_loaded && corners().iter().all(|corner| axes.height(*corner).abs() <= NEAR)
}

fn is_inside(target: &Target, axes: &Axes, at: DVec2) -> bool {
    let Some(grey) = target.shape.picture().and_then(|(_, _, pixels)| pixels.get()) else { return false };
    let size = DVec2::new(grey.width as f64, grey.height as f64);
    let dab = dab(target, axes, [at, at], 0.0);
    dab.is_some_and(|dab| dab.from.cmpge(DVec2::ZERO).all() && dab.from.cmple(size).all())
}

/// A segment of a stroke on the plane (m) in pixels of a picture.
fn dab(target: &Target, axes: &Axes, way: [DVec2; 2], diameter: f64) -> Option<Dab> {
    let (_, width, pixels) = target.shape.picture()?;
    let (grey, at) = (pixels.get()?, target.shape.centre());
    let per_metre = grey.width as f64 / width;
    let middle = DVec2::new(grey.width as f64, grey.height as f64) / 2.0;
    let back = target.turn().inverse();
    let place = |uv: DVec2| {
        let flat = (back * (axes.world(uv) - at)).truncate();
        middle + flat * DVec2::new(1.0, -1.0) * per_metre
    };
    let [from, to] = way.map(place);
    Some(Dab { from, to, radius: diameter / 2.0 * per_metre })
}

/// Changes a picture's pixels along a segment of a stroke. Returns whether a pixel changed.
fn change(
    target: &mut Target,
    dab: Option<Dab>,
    names: &Names,
    change: impl Fn(&mut Pixels, &Dab) -> bool,
) -> bool {
    let (Some(dab), Some((file, pixels))) = (dab, target.shape.picture_mut()) else { return false };
    let is_of_file = pixels.get().is_some_and(|grey| grey.file.is_some());
    let is_changed = change(pixels, &dab);
    if is_changed && is_of_file {
        *file = names.fresh();
    }
    is_changed
}

/// Names of a scene's pictures.
struct Names(BTreeSet<String>);

impl Names {
    fn of(scene: &Scene) -> Self {
        let name = |target: &Target| target.shape.picture().map(|(file, ..)| file.to_owned());
        Self(scene.targets.iter().filter_map(name).collect())
    }

    /// For a painting without a file: saving names it after the scene.
    fn fresh(&self) -> String {
        let name = |number: usize| match number {
            1 => "painting.png".to_owned(),
            _ => format!("painting-{number}.png"),
        };
        (1..).map(name).find(|name| !self.0.contains(name)).unwrap_or_default()
    }
}

/// Paints a segment of a stroke on a picture, or on a new one once it has content. Returns its index.
pub fn paint(editor: &mut Editor, axes: &Axes, index: Option<usize>, way: [DVec2; 2]) -> Option<usize> {
    let Brush { diameter, brightness } = editor.brush;
    let names = Names::of(editor.scene());
    let on = |target: &mut Target| {
        let dab = dab(target, axes, way, diameter);
        change(target, dab, &names, |pixels, dab| pixels.paint(dab, brightness as f32))
    };
    if let Some(index) = index {
        editor.document.scene.targets.get_mut(index).map(on)?;
        return Some(index);
    }
    let mut target = tool::canvas(axes, editor.scene(), names.fresh());
    if !on(&mut target) {
        return None;
    }
    editor.document.scene.targets.push(target);
    let index = editor.scene().targets.len() - 1;
    editor.selection = BTreeSet::from([index]);
    Some(index)
}

/// Erases a segment of a stroke from the selected picture, or from all in the plane.
pub fn wipe(editor: &mut Editor, axes: &Axes, way: [DVec2; 2]) {
    let diameter = editor.brush.diameter;
    let names = Names::of(editor.scene());
    let wiped: Vec<usize> = match selected(editor, axes) {
        Some(index) => vec![index],
        None => pictures_in(editor.scene(), axes).collect(),
    };
    for index in wiped {
        let target = &mut editor.document.scene.targets[index];
        let dab = dab(target, axes, way, diameter);
        change(target, dab, &names, Pixels::wipe);
    }
}

/// Deletes black pictures.
pub fn clear_away(editor: &mut Editor) {
    let is_black = |target: &Target| {
        target.shape.picture().and_then(|(_, _, pixels)| pixels.get()).is_some_and(Grey::is_black)
    };
    let targets = editor.scene().targets.iter().enumerate();
    let mut black: BTreeSet<usize> =
        targets.filter(|(_, target)| is_black(target)).map(|(index, _)| index).collect();
    if !black.is_empty() {
        edit::delete(&mut editor.document.scene, &mut black);
        editor.selection.clear();
    }
}
