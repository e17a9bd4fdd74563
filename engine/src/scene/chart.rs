//! Layout of the elements of all boards in a flat chart.

use glam::{DQuat, DVec2, DVec3};

use crate::scene::{board::Placed, content::Scene};

/// The elements of all boards, seen from the front and side by side, for charts.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Position of every element from the lower left corner, m.
    pub places: Vec<DVec2>,
    /// m
    pub size: DVec2,
    /// m, the room of an element.
    pub cell: f64,
}

impl Chart {
    pub fn new(scene: &Scene) -> Self {
        let array = &scene.array;
        let placed = array.places();
        let mean = placed.iter().map(|it| it.normal).sum::<DVec3>() / placed.len() as f64;
        let up = if mean.length() > FACING { mean.normalize_or(DVec3::Z) } else { DVec3::Z };
        let turn = DQuat::from_rotation_arc(up, DVec3::Z);
        let cell = if array.file.is_some() { 2.0 * array.element_half().min_element() } else { array.pitch };
        let flat: Vec<_> = placed.iter().map(|it| (turn * it.at).truncate()).collect();
        let grow = |(low, high): (DVec2, DVec2), at: &DVec2| (low.min(*at), high.max(*at));
        let (low, high) = flat.iter().fold((DVec2::MAX, DVec2::MIN), grow);
        let one = high - low + cell;
        // Elements that face each other are drawn side by side.
        let is_back = |it: &Placed| it.normal.dot(up) < -FACING;
        let sides = if placed.iter().any(is_back) { 2 } else { 1 };
        let step = one.x + cell / 2.0;
        let boards = scene.boards.len().max(1);
        let place = |board: usize, (it, at): (&Placed, &DVec2)| {
            let column = sides * board + usize::from(is_back(it));
            at - low + cell / 2.0 + DVec2::X * step * column as f64
        };
        let of_board = |board: usize| placed.iter().zip(&flat).map(move |pair| place(board, pair));
        let places = (0..boards).flat_map(of_board).collect();
        let columns = (sides * boards) as f64;
        Self { places, size: DVec2::new(one.x + step * (columns - 1.0), one.y), cell }
    }

    /// The element at a position.
    pub fn element(&self, at: DVec2) -> Option<usize> {
        let distances = self.places.iter().map(|place| place.distance_squared(at)).enumerate();
        let (nearest, distance) = distances.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (distance.sqrt() <= 0.75 * self.cell).then_some(nearest)
    }
}

/// Cosine beyond which two elements face each other rather than the same side.
const FACING: f64 = 0.2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::board::Board;

    #[test]
    fn charts_give_every_element_a_place_of_its_own() {
        let boards = vec![Board::default(), Board { at: DVec3::Z, ..Board::default() }];
        let scene = Scene { boards, ..Scene::default() };
        let chart = Chart::new(&scene);
        assert_eq!(chart.places.len(), 512);
        for (n, place) in chart.places.iter().enumerate() {
            assert_eq!(chart.element(*place), Some(n));
            assert!(place.cmpgt(DVec2::ZERO).all() && place.cmplt(chart.size).all());
        }
        assert_eq!(chart.element(DVec2::splat(-0.02)), None);
    }
}
