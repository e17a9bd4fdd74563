//! Directions as targets, the beam pattern of what is played, and arrows of the velocity.

use egui::accesskit::Role;
use sonoglyph::scene::Target;
use sonoglyph::ui::{Panel, figure};

use super::*;

fn tick(screen: &mut Screen, name: &str) {
    screen.get_by_role_and_label(Role::CheckBox, name).scroll_to_me();
    rest(screen);
    screen.get_by_role_and_label(Role::CheckBox, name).click();
    rest(screen);
}

/// The angle (degrees) and the level of the main lobe in the first cut.
fn main_lobe(screen: &Screen) -> (f64, f64) {
    let pattern = screen.state().editor().parts.beam.newest().unwrap();
    let main = pattern.cuts[0].main.unwrap();
    (main.top.angle.to_degrees(), main.top.level)
}

#[test]
fn a_point_becomes_a_direction_and_its_beam_is_read() {
    let mut screen = open();
    let editor = screen.state_mut().editor_mut();
    editor.document.scene.targets = vec![Target::new(Shape::Point { at: DVec3::new(0.0, 0.0, 0.1) })];
    editor.document.settle();
    editor.selection = [0].into();
    editor.panel = Panel::Scene;
    rest(&mut screen);
    tick(&mut screen, "Far away");
    assert_eq!(scene(&screen).targets[0].shape, Shape::Direction { direction: DVec3::Z });
    type_in(&mut screen, "Tilt", "20");
    let way = scene(&screen).targets[0].shape.direction().unwrap();
    let (sin, cos) = 20f64.to_radians().sin_cos();
    assert!(way.distance(DVec3::new(sin, 0.0, cos)) < 1e-12, "{way}");

    screen.state_mut().editor_mut().panel = Panel::Drive;
    rest(&mut screen);
    assert!(screen.state().editor().parts.beam.newest().is_none(), "computed on demand");
    tick(&mut screen, "Level against angle");
    let (angle, level) = main_lobe(&screen);
    // The directivity of the elements pulls the beam towards the normal.
    assert!((angle - 20.0).abs() < 0.3 && level == 0.0, "{angle}° {level} dB");
    assert!(screen.query_by_label_contains("0.00 dB at").is_some());
    let state = screen.state();
    let pieces: Vec<&str> =
        figure::available(state.editor(), state.shown()).into_iter().map(|piece| piece.into()).collect();
    assert!(pieces.contains(&"Beam pattern") && pieces.contains(&"Beam pattern, polar"), "{pieces:?}");

    // A drag turns the arrow.
    let target = &mut screen.state_mut().editor_mut().document.scene.targets[0];
    target.shape.translate(DVec3::X * -0.05);
    rest(&mut screen);
    assert!(main_lobe(&screen).0 < 0.0, "{:?}", main_lobe(&screen));
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert!(main_lobe(&screen).0 > 0.0, "undone");
}

#[test]
fn arrows_of_a_velocity_are_shown_on_its_map() {
    let mut screen = open();
    screen.state_mut().editor_mut().view.quantity = Quantity::Rms;
    rest(&mut screen);
    assert!(
        screen.query_by_role_and_label(Role::CheckBox, "Arrows").is_none(),
        "a pressure has no direction"
    );
    screen.state_mut().editor_mut().view.quantity = Quantity::Speed;
    rest(&mut screen);
    tick(&mut screen, "Arrows");
    let field = screen.state().editor().parts.arrows.newest().unwrap();
    assert!(field.places.len() > 20 && field.vectors.iter().any(|way| way.length() > 0.0));
    assert!(field.vectors.iter().all(|way| way.z == 0.0), "in the displayed plane");
}
