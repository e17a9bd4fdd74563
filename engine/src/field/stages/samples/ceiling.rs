//! Tests of the limit of tables.

use glam::{DVec2, dvec3};

use super::*;
use crate::field::Plan;
use crate::field::plan::Costs;
use crate::scene::{Array, Plane, Scene};

#[test]
fn tables_of_many_elements_at_many_samples_do_not_fit() {
    let array = Array { columns: 64, rows: 64, ..Array::default() };
    let aperture = Aperture::new(&Scene { array, ..Scene::default() });
    for (side, fits) in [(0.1, true), (0.5, false)] {
        // No sample has the same way to two elements.
        let plane = Plane {
            centre: dvec3(0.0, 0.0, 0.2),
            size: DVec2::splat(side),
            x_axis: dvec3(1.0, 0.3, 0.0),
            ..Plane::default()
        };
        let grid = Plan::new(&aperture, &plane, Costs::CPU).unwrap().grid.unwrap();
        let bytes = grid.samples.len() * aperture.positions.len() * size_of::<Complex32>();
        assert_eq!(bytes < TABLE_CEILING, fits, "{bytes}");
        let key = TableKey { aperture: aperture.clone(), grid, direction: None };
        assert_eq!(key.fits(), fits, "{side} m");
    }
}
