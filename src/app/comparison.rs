//! The comparison map: another drive's or another plane's map, with stages of its own, and the difference.

use egui::Context;

use crate::app::mapping::{Look, Mapping, NEAREST, image, in_egui};
use crate::app::posing::{Source, sound};
use crate::drive::Drive;
use crate::field::{Colouring, Range, Request, hatch};
use crate::picture::{ColourMap, Picture};
use crate::scene::{Method, Scene};
use crate::studio::later::Later;
use crate::studio::map;
use crate::studio::performance::Performance;
use crate::studio::posing::{posed, posed_in_motion};
use crate::studio::solving;
use crate::ui::beside::{Beside, Compare, Difference, With};
use crate::ui::part::wake;
use crate::ui::view::Lens;
use crate::ui::{Editor, Map, Moment, Shown, level, sound};

/// A second map beside the first.
#[derive(Debug)]
pub struct Comparison {
    mapping: Mapping,
    /// The performance of a scene, at rest or in motion.
    solving: Later<(Scene, bool), Result<Performance, String>>,
    /// The requests of the displayed difference, whether it is on a light ground, and its picture.
    subtracted: Option<((Request, Request, bool), Picture)>,
}

/// The largest value of both maps, if they share a colour range.
pub fn common_range(editor: &Editor, shown: &Shown) -> Option<f64> {
    editor.compare.as_ref()?;
    let (own, other) = (shown.map.as_ref()?, shown.beside.as_ref()?.map.as_ref()?);
    let quantity = editor.view.quantity;
    let is_one = own.quantity == quantity && other.quantity == quantity;
    let has_range = quantity.declaration().range != Range::Cyclic;
    let largest = own.largest.max(other.largest);
    (is_one && has_range && editor.view.full.is_none() && largest > 0.0).then_some(largest)
}

impl Comparison {
    pub fn new(mapping: Mapping) -> Self {
        Self { mapping, solving: Later::default(), subtracted: None }
    }

    /// The request of the second map.
    pub fn request(&self) -> Option<&Request> {
        self.mapping.request()
    }

    /// The picture on the screen.
    pub fn picture(&mut self) -> Option<Picture> {
        match &self.subtracted {
            Some((_, difference)) => Some(difference.clone()),
            None => self.mapping.picture(),
        }
    }

    pub fn is_busy(&self) -> bool {
        self.mapping.is_awaiting() || self.solving.is_running()
    }

    /// Updates the comparison; `source` is the map's source, and `own` its mapping.
    pub fn update(
        &mut self,
        (editor, compare): (&Editor, &Compare),
        shown: &mut Shown,
        source: Option<&Source>,
        lens: &Lens,
        own: &mut Mapping,
        ctx: &Context,
    ) {
        if self.solving.collect() {
            ctx.request_repaint();
        }
        let range = common_range(editor, shown);
        let mut beside = shown.beside.take().unwrap_or_default();
        (beside.problem, beside.is_pending) = (None, false);
        // A mean is one over all frames.
        let quantity = editor.view.quantity;
        let is_mean = sound::is_of_all_frames(quantity, editor.playback);
        let round = shown.round.clone().filter(|_| is_mean);
        let is_mean = round.is_some();
        let mean =
            round.map(|round| Source { performance: Performance::Motion(round), moment: Moment::Mean });
        let source = mean.or_else(|| source.cloned());
        let source = match (compare.with, source) {
            (With::Method, Some(source)) => self.by(compare.method, editor, &source, &mut beside, ctx),
            (With::Levels | With::Plane, source) => source,
            (With::Method, None) => None,
        };
        let levels = if compare.with == With::Levels { Some(compare.levels) } else { editor.levels };
        // Until it is solved, the previous result stays.
        if source.is_some() || !beside.is_pending {
            beside.sound = source.as_ref().map(|source| sound(editor.scene(), levels, source));
        }
        let view = compare.view(&editor.view);
        let drives: Vec<_> = match (&source, &beside.sound) {
            (Some(Source { performance, .. }), _) if is_mean => {
                let at_levels = |drive: Drive| match levels {
                    Some(levels) => drive.at_levels(levels),
                    None => drive,
                };
                performance.drives().into_iter().map(at_levels).collect()
            }
            (_, own) => sound::drives(None, own.as_ref(), editor.playback, quantity),
        };
        let look = Look {
            scene: editor.scene(),
            view: &view,
            sound: beside.sound.as_ref().filter(|_| !drives.is_empty() && view.suits(editor.scene())),
            drives,
            moment: editor.oscillation.part,
            full: range,
            lens,
            surface: None,
            is_veil: false,
        };
        if !view.suits(editor.scene()) {
            beside.problem = Some(level::MUST_BE_LEVEL.to_owned());
        }
        let done = self.mapping.update(&look, &mut beside.map, ctx);
        beside.problem = beside.problem.or(done.problem).or(done.gave_up);
        self.subtract((compare, view.is_light), shown.map.as_ref(), &mut beside, own, ctx);
        shown.beside = Some(beside);
        if common_range(editor, shown) != range {
            // The left map has already been drawn.
            ctx.request_repaint();
        }
    }

    /// The same moment of the scene, solved by another method.
    fn by(
        &mut self,
        method: Method,
        editor: &Editor,
        source: &Source,
        beside: &mut Beside,
        ctx: &Context,
    ) -> Option<Source> {
        if method == editor.scene().solver.method && !editor.scene().drive.is_named() {
            return Some(source.clone());
        }
        let (mut scene, moves) = match &source.performance {
            Performance::Still(_) => (posed(editor.scene()), false),
            Performance::Motion(_) => (posed_in_motion(editor.scene()), true),
        };
        scene.solve_by(method);
        let wanted = (scene, moves);
        self.solving.ask(&wanted, wake(ctx), |(scene, moves)| match moves {
            false => solving::solve(scene, &mut |_| {}).map(Performance::Still),
            true => solving::follow(scene).map(Performance::Motion),
        });
        let found = self.solving.get(&wanted).cloned();
        match found {
            Some(Ok(performance)) => return Some(Source { performance, ..*source }),
            Some(Err(problem)) => beside.problem = Some(problem),
            None => beside.is_pending = true,
        }
        None
    }

    /// Map minus map, pixel by pixel.
    fn subtract(
        &mut self,
        (compare, is_light): (&Compare, bool),
        own_map: Option<&Map>,
        beside: &mut Beside,
        own: &mut Mapping,
        ctx: &Context,
    ) {
        let is_wanted = compare.is_subtracted();
        let sides = own.request().cloned().zip(self.mapping.request().cloned());
        let Some((left, right)) = sides.filter(|_| is_wanted) else {
            (beside.difference, self.subtracted) = (None, None);
            return;
        };
        let (Some(map), true) = (own_map, own.is_complete() && self.mapping.is_complete()) else { return };
        if left.size != right.size || left.quantity != right.quantity || map.exaggeration.is_some() {
            (beside.difference, self.subtracted) = (None, None);
            return;
        }
        let key = (left, right, is_light);
        if self.subtracted.as_ref().is_some_and(|(own, _)| *own == key) {
            return;
        }
        let (Some((_, left)), Some((_, right))) = (own.numbers(), self.mapping.numbers()) else { return };
        let values = map::difference(key.0.quantity, &left, &right);
        let largest = values.iter().fold(0.0_f32, |most, value| most.max(value.abs()));
        let table = ColourMap::Diverging.on(is_light);
        let colouring = Colouring {
            range: Range::Signed,
            full: Some(largest.max(f32::MIN_POSITIVE)),
            ..Colouring::new(key.0.quantity, table)
        };
        let mut colours = Vec::new();
        colouring.colours(&values, largest, &mut colours);
        hatch(&values, key.0.size.0, &mut colours);
        let (width, height) = key.0.size;
        let picture = Picture::from_field_order(width, height, colours.as_flattened());
        let before = beside.difference.take().map(|difference| difference.texture);
        let texture = in_egui(before, image([width, height], &colours), NEAREST, ctx);
        let (window, rect) = (map.window, map.rect);
        let (largest, quantity) = (largest.into(), key.0.quantity);
        beside.difference = Some(Difference { texture, largest, quantity, window, rect });
        self.subtracted = Some((key, picture));
    }
}
