//! Models of elements and their keys on the Scene page.

use sonoglyph::scene::ElementModel;

use super::*;

#[test]
fn every_model_has_its_keys_on_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = open();
    screen.get_by_label("Array").click();
    rest(&mut screen);
    pick(&mut screen, "Directivity", "rectangle, far field");
    type_in(&mut screen, "Element width", "8");
    type_in(&mut screen, "Element height", "3");
    let array = &scene(&screen).array;
    assert_eq!((array.element, array.element_size), (ElementModel::Rectangle, DVec2::new(0.008, 0.003)));
    pick(&mut screen, "Directivity", "power of the cosine");
    type_in(&mut screen, "Exponent", "2.5");
    assert_eq!(scene(&screen).array.element_exponent, 2.5);
    let path = folder.path().join("mine.csv");
    std::fs::write(&path, "angle,amplitude\n0,1\n45,0.5\n90,0.1\n").unwrap();
    pick(&mut screen, "Directivity", "measured");
    assert_eq!(scene(&screen).array.element, ElementModel::Cosine, "without a table it is asked for");
    answer(&mut screen, Purpose::Directivity, &path);
    rest(&mut screen);
    let array = &scene(&screen).array;
    assert_eq!(array.element, ElementModel::Measured);
    assert_eq!(array.measured.get().unwrap().readings.len(), 3);
    type_in(&mut screen, "Frequency", "3125");
    assert_eq!(scene(&screen).array.frequency, 3.125e6);
}
