//! The comparison map: another drive's or another plane's map, with stages of its own, and the difference.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use egui::Context;

use crate::app::later::Later;
use crate::app::mapping::{Look, Mapping, image, in_egui};
use crate::app::posing::{Solved, Source, solve, sound};
use crate::drive::Drive;
use crate::field::quantity::Range;
use crate::field::{Colouring, Request};
use crate::picture::ColourMap;
use crate::scene::{Method, Scene};
use crate::solver::frames::{self, Sequence};
use crate::studio::posing::{posed, posed_in_motion};
use crate::ui::beside::{Beside, Compare, Difference, With};
use crate::ui::view::Lens;
use crate::ui::{Editor, Map, Shown};

/// A second map beside the first.
#[derive(Debug)]
pub struct Comparison {
    mapping: Mapping,
    solving: Later<Scene, Solved>,
    following: Later<Scene, Result<Arc<Sequence>, String>>,
    /// The requests of the displayed difference, and whether it is on a light ground.
    subtracted: Option<(Request, Request, bool)>,
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

/// The drives of all frames, quantised to a number of phase levels if given.
fn all_drives(round: &Sequence, levels: Option<u32>) -> Vec<Drive> {
    let played = |drive: &Drive| levels.map_or_else(|| drive.clone(), |levels| drive.at_levels(levels));
    round.frames.iter().map(|frame| played(&frame.drive)).collect()
}

impl Comparison {
    pub fn new(mapping: Mapping) -> Self {
        Self { mapping, solving: Later::default(), following: Later::default(), subtracted: None }
    }

    pub fn is_busy(&self) -> bool {
        self.mapping.is_awaiting() || self.solving.is_running() || self.following.is_running()
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
        if [self.solving.collect(), self.following.collect()].contains(&true) {
            ctx.request_repaint();
        }
        let range = common_range(editor, shown);
        let mut beside = shown.beside.take().unwrap_or_default();
        (beside.problem, beside.is_pending) = (None, false);
        // A mean is one over all frames.
        let is_mean = editor.view.quantity.declaration().is_slow && editor.playback.frame.is_none();
        let round = shown.round.clone().filter(|_| is_mean);
        let is_mean = round.is_some();
        let source = round.map(|round| Source::Frame(round, 0)).or_else(|| source.cloned());
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
        let drives = match (&source, &beside.sound) {
            (Some(Source::Frame(round, _)), _) if is_mean => all_drives(round, levels),
            (_, sound) => sound.iter().flat_map(|sound| sound.drives.clone()).collect(),
        };
        let look = Look {
            scene: editor.scene(),
            view: &view,
            sound: beside.sound.as_ref().filter(|_| !drives.is_empty()),
            drives,
            moment: editor.oscillation.part,
            full: range,
            lens,
            is_veil: false,
        };
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
        if method == editor.scene().solver.method {
            return Some(source.clone());
        }
        let with_method = |mut scene: Scene| {
            scene.solver.method = method;
            scene
        };
        let found = match source {
            Source::Still(_) => {
                let posed = with_method(posed(editor.scene()));
                self.solving.ask(&posed, ctx, solve);
                self.solving.get(&posed).map(|solved| solved.clone().map(Source::Still))
            }
            Source::Frame(_, frame) => {
                let moving = with_method(posed_in_motion(editor.scene()));
                self.following.ask(&moving, ctx, |scene| {
                    frames::follow(scene).map(Arc::new).map_err(|error| error.to_string())
                });
                let followed = self.following.get(&moving);
                followed.map(|round| round.clone().map(|round| Source::Frame(round, *frame)))
            }
        };
        match found {
            Some(Ok(source)) => return Some(source),
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
        if self.subtracted.as_ref() == Some(&key) {
            return;
        }
        let (Some((_, left)), Some((_, right))) = (own.numbers(), self.mapping.numbers()) else { return };
        let is_cyclic = key.0.quantity.declaration().range == Range::Cyclic;
        let minus = |(a, b): (f32, f32)| {
            let difference = a - b;
            if is_cyclic { (difference + PI).rem_euclid(TAU) - PI } else { difference }
        };
        let values: Vec<_> = left.into_iter().zip(right).map(minus).collect();
        let largest = values.iter().fold(0.0_f32, |most, value| most.max(value.abs()));
        let table = ColourMap::Diverging.on(is_light);
        let colouring = Colouring {
            range: Range::Signed,
            full: Some(largest.max(f32::MIN_POSITIVE)),
            ..Colouring::new(key.0.quantity, table)
        };
        let mut colours = Vec::new();
        colouring.colours(&values, largest, &mut colours);
        let (width, height) = key.0.size;
        let before = beside.difference.take().map(|difference| difference.texture);
        let texture = in_egui(before, image([width, height], &colours), ctx);
        let (window, rect) = (map.window, map.rect);
        let (largest, quantity) = (largest.into(), key.0.quantity);
        beside.difference = Some(Difference { texture, largest, quantity, window, rect });
        self.subtracted = Some(key);
    }
}
