//! Tests of the memory that is kept from site to site.

use super::*;
use crate::drive::Drive;
use crate::field::stages::Request;
use crate::scene::{Array, Scene};

#[test]
fn much_memory_is_given_back_at_another_site() {
    let site = |height: f64| {
        let array = Array { columns: 2, rows: 2, ..Array::default() };
        let mut scene = Scene { array, ..Scene::default() };
        scene.plane.centre.z = height;
        let drive = Drive { amplitudes: vec![1.0; 4], phases: vec![0.0; 4] };
        SiteKey::new(&Request::new(&scene, vec![drive], field::Quantity::Rms, (8, 8)), false)
    };
    let (low, high) = (site(0.1), site(0.2));
    let mut stages = OnCpu::default();
    stages.enter(&low);
    // As much as may be kept, and a bit more.
    let most = MOST_REUSED / size_of::<f64>();
    stages.cells.value = Vec::with_capacity(most);
    assert_eq!(stages.bytes(), MOST_REUSED);
    stages.enter(&high);
    assert_eq!(stages.bytes(), MOST_REUSED);
    stages.cells.value = Vec::with_capacity(most + 1);
    stages.enter(&high);
    assert!(stages.bytes() > MOST_REUSED, "the site is the same");
    stages.enter(&low);
    assert_eq!(stages.bytes(), 0);
}
