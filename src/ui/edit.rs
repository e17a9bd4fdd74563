//! Edits of a scene's targets by tools and keys.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use strum::{IntoStaticStr, VariantArray};

use crate::scene::{MotionPath, Scene, Target, file, outline};
use crate::ui::group;
use crate::ui::view::Axes;

/// Offset of a copy from its original, m.
const BESIDE: f64 = 0.01;

pub fn delete(scene: &mut Scene, selection: &mut BTreeSet<usize>) {
    let mut index = 0;
    scene.targets.retain(|_| {
        index += 1;
        !selection.contains(&(index - 1))
    });
    selection.clear();
}

/// The selection as text and as values.
pub fn copied(scene: &Scene, selection: &BTreeSet<usize>) -> Option<(String, Vec<Target>)> {
    let targets: Vec<Target> =
        selection.iter().filter_map(|&index| scene.targets.get(index)).cloned().collect();
    (!targets.is_empty()).then(|| (file::write_targets(&targets), targets))
}

/// Restores the pixels of pasted pictures from the copied originals: paintings may have no file.
pub fn return_pixels(pasted: &mut [Target], copied: &[Target]) {
    if pasted.len() != copied.len() {
        return;
    }
    for (target, copied) in pasted.iter_mut().zip(copied) {
        if let (Some((file, pixels)), Some((own, _, painted))) =
            (target.shape.picture_mut(), copied.shape.picture())
            && file == own
        {
            *pixels = painted.clone();
        }
    }
}

/// Adds the targets of a text, offset from their position, and selects them. Returns whether there were any.
pub fn paste(scene: &mut Scene, selection: &mut BTreeSet<usize>, axes: &Axes, text: &str) -> bool {
    let Some(mut targets) = file::parse_targets(text).filter(|targets| !targets.is_empty()) else {
        return false;
    };
    let by = (axes.x - axes.y) * BESIDE;
    for target in &mut targets {
        target.shape.translate(by);
        // Steps only exist in scenes with turns.
        target.step = target.step.filter(|_| scene.motion.path == MotionPath::Steps);
    }
    let first = scene.targets.len();
    scene.targets.extend(targets);
    group::part(&mut scene.targets, first);
    *selection = (first..scene.targets.len()).collect();
    true
}

/// Moves a target in the list, before the one at `to` or to the end. Returns its new index.
pub fn reorder(scene: &mut Scene, from: usize, to: usize) -> usize {
    if from >= scene.targets.len() {
        return from;
    }
    let target = scene.targets.remove(from);
    let place = if from < to { to - 1 } else { to }.min(scene.targets.len());
    scene.targets.insert(place, target);
    place
}

/// Duplicates the selection and selects the copies.
pub fn duplicate(scene: &mut Scene, selection: &mut BTreeSet<usize>, axes: &Axes) {
    copy_in_place(scene, selection);
    let by = (axes.x - axes.y) * BESIDE;
    for &index in selection.iter() {
        scene.targets[index].shape.translate(by);
    }
}

/// Name of a target in lists.
pub fn name(target: &Target) -> String {
    if target.name.is_empty() { target.shape.title() } else { target.name.clone() }
}

/// The outlines of a target on a cut.
pub fn outline_on(target: &Target, axes: &Axes) -> Vec<Vec<DVec2>> {
    let flat = |stroke: Vec<DVec3>| stroke.into_iter().map(|point| axes.flat(point)).collect();
    outline::strokes(target).unwrap_or_default().into_iter().map(flat).collect()
}

/// Low and high corner (m) of the box around targets on a cut.
pub fn bounds<'a>(targets: impl IntoIterator<Item = &'a Target>, axes: &Axes) -> Option<[DVec2; 2]> {
    let points = targets.into_iter().flat_map(|target| outline_on(target, axes).concat());
    points.map(|point| [point; 2]).reduce(|[low, high], [a, b]| [low.min(a), high.max(b)])
}

/// Alignment of selected targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(const_into_str)]
pub enum Align {
    #[strum(serialize = "Align left")]
    Left,
    #[strum(serialize = "Align centres")]
    Centre,
    #[strum(serialize = "Align right")]
    Right,
    #[strum(serialize = "Align top")]
    Top,
    #[strum(serialize = "Align middles")]
    Middle,
    #[strum(serialize = "Align bottom")]
    Bottom,
}

/// Aligns the selection with its bounding box.
pub fn align(scene: &mut Scene, selection: &BTreeSet<usize>, axes: &Axes, align: Align) {
    let chosen = || selection.iter().copied().filter(|&index| index < scene.targets.len());
    let boxes: Vec<_> = chosen()
        .filter_map(|index| bounds([&scene.targets[index]], axes).map(|around| (index, around)))
        .collect();
    let whole = boxes.iter().map(|(_, around)| *around).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let Some(whole) = whole else { return };
    for (index, own) in boxes {
        let [low, high] = [whole[0] - own[0], whole[1] - own[1]];
        let by = match align {
            Align::Left => DVec2::new(low.x, 0.0),
            Align::Centre => DVec2::new((low.x + high.x) / 2.0, 0.0),
            Align::Right => DVec2::new(high.x, 0.0),
            Align::Top => DVec2::new(0.0, high.y),
            Align::Middle => DVec2::new(0.0, (low.y + high.y) / 2.0),
            Align::Bottom => DVec2::new(0.0, low.y),
        };
        scene.targets[index].shape.translate(axes.x * by.x + axes.y * by.y);
    }
}

/// Equalises the gaps in the selection along the horizontal or vertical axis, keeping the outermost targets.
pub fn distribute(scene: &mut Scene, selection: &BTreeSet<usize>, axes: &Axes, is_upwards: bool) {
    let along = |at: DVec2| if is_upwards { at.y } else { at.x };
    let mut spans: Vec<_> = selection
        .iter()
        .filter_map(|&index| Some((index, bounds([scene.targets.get(index)?], axes)?.map(along))))
        .collect();
    spans.sort_by(|(_, a), (_, b)| (a[0] + a[1]).total_cmp(&(b[0] + b[1])));
    let [(_, first), .., (_, last)] = spans[..] else { return };
    let filled: f64 = spans.iter().map(|(_, [low, high])| high - low).sum();
    let gap = (last[1] - first[0] - filled) / (spans.len() - 1) as f64;
    let direction = if is_upwards { axes.y } else { axes.x };
    let mut place = first[0];
    for (index, [low, high]) in spans {
        scene.targets[index].shape.translate(direction * (place - low));
        place += high - low + gap;
    }
}

/// Copies the selection in place and selects the copies.
pub fn copy_in_place(scene: &mut Scene, selection: &mut BTreeSet<usize>) {
    let copies: Vec<Target> =
        selection.iter().filter_map(|&index| scene.targets.get(index)).cloned().collect();
    let first = scene.targets.len();
    scene.targets.extend(copies);
    group::part(&mut scene.targets, first);
    *selection = (first..scene.targets.len()).collect();
}

/// The topmost target with its outline within `reach` (m) of a point of the plane, or with the point inside its
/// letters.
pub fn target_at(scene: &Scene, axes: &Axes, at: DVec2, reach: f64) -> Option<usize> {
    target_among(scene, axes, at, reach, |_| true)
}

/// The same among those of some kind.
pub fn target_among(
    scene: &Scene,
    axes: &Axes,
    at: DVec2,
    reach: f64,
    is_meant: impl Fn(&Target) -> bool,
) -> Option<usize> {
    let distance = |target: &Target| {
        if !target.visible || !is_meant(target) {
            return f64::INFINITY;
        }
        let strokes = outline_on(target, axes);
        strokes.iter().map(|stroke| distance_to(stroke, at)).fold(f64::INFINITY, f64::min)
    };
    let distances: Vec<_> = scene.targets.iter().map(distance).collect();
    let nearest = (0..distances.len()).rev().min_by(|&a, &b| distances[a].total_cmp(&distances[b]))?;
    (distances[nearest] <= reach).then_some(nearest)
}

/// Targets with all of their outline in a box of the cut.
pub fn targets_in(scene: &Scene, axes: &Axes, a: DVec2, b: DVec2) -> BTreeSet<usize> {
    let (low, high) = (a.min(b), a.max(b));
    let inside = |p: &DVec2| p.cmpge(low).all() && p.cmple(high).all();
    let whole = |target: &Target| {
        let outline = outline_on(target, axes).concat();
        target.visible && !outline.is_empty() && outline.iter().all(inside)
    };
    (0..scene.targets.len()).filter(|&index| whole(&scene.targets[index])).collect()
}

fn distance_to(stroke: &[DVec2], at: DVec2) -> f64 {
    let to_piece = |pair: &[DVec2]| {
        let along = pair[1] - pair[0];
        let part = ((at - pair[0]).dot(along) / along.length_squared().max(1e-30)).clamp(0.0, 1.0);
        at.distance(pair[0] + along * part)
    };
    match stroke {
        [only] => at.distance(*only),
        _ => stroke.windows(2).map(to_piece).fold(f64::INFINITY, f64::min),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Shape;
    use crate::ui::view::View;

    fn scene() -> (Scene, Axes) {
        let at = DVec3::new(0.0, 0.0, 0.1);
        let targets = vec![
            Target::new(Shape::Point { at: at + DVec3::X * 0.05 }),
            Target::new(Shape::Circle { at, radius: 0.02 }),
            Target::new(Shape::Line { from: at - DVec3::Y * 0.05, to: at - DVec3::new(0.05, 0.05, 0.0) }),
        ];
        let scene = Scene { targets, ..Scene::default() };
        let axes = View::of(&scene).axes(&scene);
        (scene, axes)
    }

    #[test]
    fn targets_are_found_at_their_outlines() {
        let (scene, axes) = scene();
        let at = |x: f64, y: f64| target_at(&scene, &axes, DVec2::new(x, y), 0.003);
        assert_eq!(at(0.05, 0.002), Some(0));
        assert_eq!(at(0.0, 0.0201), Some(1));
        assert_eq!(at(-0.03, -0.049), Some(2));
        assert_eq!(at(0.0, 0.0), None);
        let band = targets_in(&scene, &axes, DVec2::new(0.06, 0.03), DVec2::new(-0.03, -0.03));
        assert_eq!(band, BTreeSet::from([0, 1]));
    }

    #[test]
    fn targets_go_through_a_text_and_come_out_beside_where_they_stood() {
        let (mut scene, axes) = scene();
        scene.targets[1].visible = false;
        let (text, _) = copied(&scene, &BTreeSet::from([0, 1])).unwrap();
        assert_eq!(copied(&scene, &BTreeSet::new()), None);
        let mut selection = BTreeSet::new();
        assert!(!paste(&mut scene, &mut selection, &axes, "some words") && scene.targets.len() == 3);
        assert!(paste(&mut scene, &mut selection, &axes, &text));
        assert_eq!((scene.targets.len(), &selection), (5, &BTreeSet::from([3, 4])));
        let by = outline::centre(&scene.targets[4].shape) - outline::centre(&scene.targets[1].shape);
        assert!(by.distance(DVec3::new(BESIDE, -BESIDE, 0.0)) < 1e-12 && !scene.targets[4].visible);
    }

    #[test]
    fn a_target_goes_where_it_is_dropped_in_the_list() {
        for (from, to, order, place) in
            [(0, 3, [1, 2, 0], 2), (2, 0, [2, 0, 1], 0), (1, 1, [0, 1, 2], 1), (1, 2, [0, 1, 2], 1)]
        {
            let (mut scene, _) = scene();
            let before = scene.targets.clone();
            assert_eq!(reorder(&mut scene, from, to), place);
            assert_eq!(scene.targets, order.map(|index| before[index].clone()));
        }
    }

    #[test]
    fn what_is_aligned_shares_an_edge_and_what_is_distributed_has_equal_gaps() {
        let (scene, axes) = scene();
        let all = BTreeSet::from([0, 1, 2]);
        let spans =
            |scene: &Scene| scene.targets.iter().map(|it| bounds([it], &axes).unwrap()).collect::<Vec<_>>();
        let middle = |[low, high]: [DVec2; 2]| (low + high) / 2.0;
        type Pick = fn([DVec2; 2]) -> f64;
        let edges: [(Align, Pick, f64); 6] = [
            (Align::Left, |it| it[0].x, -0.05),
            (Align::Centre, |it| (it[0].x + it[1].x) / 2.0, 0.0),
            (Align::Right, |it| it[1].x, 0.05),
            (Align::Top, |it| it[1].y, 0.02),
            (Align::Middle, |it| (it[0].y + it[1].y) / 2.0, -0.015),
            (Align::Bottom, |it| it[0].y, -0.05),
        ];
        for (edge, pick, at) in edges {
            let mut aligned = scene.clone();
            align(&mut aligned, &all, &axes, edge);
            for (own, before) in spans(&aligned).into_iter().zip(spans(&scene)) {
                assert!((pick(own) - at).abs() < 1e-9, "{edge:?}: {own:?}");
                let by = middle(own) - middle(before);
                assert!(by.x.abs() < 1e-9 || by.y.abs() < 1e-9, "{edge:?} moves along one axis");
            }
        }
        let mut apart = scene.clone();
        distribute(&mut apart, &all, &axes, false);
        let mut spans = spans(&apart);
        spans.sort_by(|a, b| a[0].x.total_cmp(&b[0].x));
        let gaps: Vec<_> = spans.windows(2).map(|pair| pair[1][0].x - pair[0][1].x).collect();
        assert!((gaps[0] - gaps[1]).abs() < 1e-9, "{gaps:?}");
        assert!(
            (spans[0][0].x + 0.05).abs() < 1e-9 && (spans[2][1].x - 0.05).abs() < 1e-9,
            "the outermost stay"
        );
    }

    #[test]
    fn copies_are_selected_and_deleting_leaves_the_rest() {
        let (mut scene, axes) = scene();
        let before = scene.clone();
        let mut selection = BTreeSet::from([0, 2]);
        duplicate(&mut scene, &mut selection, &axes);
        assert_eq!((scene.targets.len(), &selection), (5, &BTreeSet::from([3, 4])));
        delete(&mut scene, &mut selection);
        assert_eq!(scene, before);
    }
}
