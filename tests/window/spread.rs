//! Elements that differ: the ranges of the Solver page and the band of the line profile.

use sonoglyph::scene::Target;
use sonoglyph::ui::Panel;
use sonoglyph::ui::section::Profile;

use super::*;

#[test]
fn a_spread_of_elements_has_ranges_and_a_band() {
    let mut screen = open();
    let editor = screen.state_mut().editor_mut();
    editor.document.scene.targets = vec![Target::new(Shape::Point { at: DVec3::new(0.0, 0.0, 0.1) })];
    editor.document.settle();
    editor.view.section = true;
    rest(&mut screen);
    let ranges = |screen: &Screen| screen.state().editor().parts.ranges.exact().cloned().flatten();
    let profile = |screen: &Screen| Profile::of(screen.state().editor(), screen.state().shown()).unwrap();
    assert_eq!(profile(&screen).band, None);
    screen.get_by_label("Array").click();
    rest(&mut screen);
    type_in(&mut screen, "Spread of gain", "10");
    type_in(&mut screen, "Spread of phase", "20");
    rest(&mut screen);
    let spread = scene(&screen).array.spread;
    assert!(spread.gain == 0.1 && (spread.phase.to_degrees() - 20.0).abs() < 1e-9, "{spread:?}");
    assert_eq!(ranges(&screen), None, "computed on demand");
    let (values, band) = (profile(&screen).values, profile(&screen).band.unwrap());
    let inside = values.iter().zip(&band).filter(|(value, [low, high])| low < value && *value < high).count();
    assert_eq!((band.len(), inside), (values.len(), values.len()));
    screen.state_mut().editor_mut().panel = Panel::Solver;
    rest(&mut screen);
    let [mean, _] = ranges(&screen).unwrap().won;
    assert!((mean - (spread.phase.powi(2) / 2.0).exp()).abs() < 5e-4, "{mean}");
    screen.get_by_label("Gain by calibration");
}
