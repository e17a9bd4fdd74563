//! A bead in the window: points as traps, trapping of the bead, and arrows of the force over the map.

use egui::accesskit::Role;
use sonoglyph::force::{Levitation, Outcome};
use sonoglyph::scene::{Board, Material, Target, Trap};
use sonoglyph::ui::Panel;
use sonoglyph::ui::parts::levitation::Levitated;

use super::*;

const AT: DVec3 = DVec3::new(0.004, -0.003, 0.1);

/// The window with a trap between two boards and the bead's figures.
fn open_on_trap() -> Screen {
    let mut screen = open();
    let editor = screen.state_mut().editor_mut();
    // A single board cannot lift a bead of 0.5 mm.
    let above = Board { at: DVec3::Z * 0.2, normal: DVec3::NEG_Z, ..Board::default() };
    editor.document.scene.boards = vec![Board::default(), above];
    editor.document.scene.targets = vec![Target::new(Shape::Point { at: AT })];
    editor.document.settle();
    editor.panel = Panel::Scene;
    editor.selection = [0].into();
    rest(&mut screen);
    pick(&mut screen, "Trap", "standing wave");
    screen.state_mut().editor_mut().document.settle();
    // Makes room for the page.
    screen.state_mut().editor_mut().selection.clear();
    rest(&mut screen);
    screen.get_by_label("Bead").click();
    rest(&mut screen);
    screen.get_by_label("Force at a point").click();
    rest(&mut screen);
    screen
}

fn levitated(screen: &Screen) -> Levitated {
    screen.state().editor().parts.levitation.newest().cloned().expect("the bead has figures")
}

/// The library's levitation of the scene on the screen.
fn levitation(screen: &Screen) -> Levitation {
    let sound = screen.state().shown().sound.as_ref().unwrap();
    Levitation::new(scene(screen), &sound.aperture, &sound.drives)
}

#[test]
fn a_point_becomes_a_trap_for_light_beads_but_not_for_heavy_ones() {
    let mut screen = open_on_trap();
    assert_eq!(scene(&screen).targets[0].shape, Shape::Trap { at: AT, trap: Trap::Standing, charge: 1 });
    let found = levitated(&screen);
    assert_eq!((found.hold.at, found.hold.outcome), (AT, Outcome::Holds));
    assert_eq!(found.hold, levitation(&screen).hold(AT));
    assert!(found.hold.sag().abs() < 1e-4 && found.load > 0.0);
    assert!(screen.query_by_label_contains("Stable trap: sag").is_some());
    for (axis, curve) in found.curves.iter().enumerate() {
        let middle = curve[curve.len() / 2];
        assert!(
            middle[0].abs() < 1e-12 && (middle[1] - found.forces.force[axis]).abs() < 1e-15,
            "{middle:?}"
        );
    }

    pick(&mut screen, "Material", "fused silica");
    assert_eq!(scene(&screen).bead.material, Material::Silica);
    let heavy = levitated(&screen);
    assert!(heavy.load > 70.0 * found.load && heavy.hold.lift < found.hold.lift / 60.0, "{heavy:?}");
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(levitated(&screen).hold, found.hold, "one step back");

    // A single board that is too weak for its weight.
    screen.state_mut().editor_mut().document.scene.boards.clear();
    screen.state_mut().editor_mut().document.scene.array.strength = 0.1;
    rest(&mut screen);
    assert!(!levitated(&screen).hold.holds());
    assert!(screen.query_by_label_contains("No trap: ").is_some());

    screen.get_by_label("Force at a point").click();
    rest(&mut screen);
    assert_eq!(screen.state().editor().parts.levitation.newest(), None, "computed on demand");
}

#[test]
fn arrows_are_the_forces_on_the_plane() {
    let mut screen = open_on_trap();
    assert_eq!(screen.state().editor().parts.arrows.newest(), None, "computed on demand");
    screen.get_by_label("Arrows on the map").click();
    rest(&mut screen);
    let arrows = screen.state().editor().parts.arrows.newest().cloned().unwrap();
    assert!(arrows.places.len() > 100 && arrows.places.len() == arrows.vectors.len());
    let height = scene(&screen).plane.centre.z;
    assert!(arrows.places.iter().all(|place| (place.z - height).abs() < 1e-12));
    assert_eq!(arrows.vectors, levitation(&screen).forces_at(&arrows.places));
    // They stay on other pages, and vanish with the map.
    screen.state_mut().editor_mut().panel = Panel::Solver;
    rest(&mut screen);
    let parts = &screen.state().editor().parts;
    assert!(parts.arrows.newest().is_some() && parts.levitation.newest().is_none());
    key(&mut screen, Key::F3);
    assert_eq!(screen.state().editor().parts.arrows.newest(), None);
}

#[test]
fn the_force_map_comes_coarse_then_whole_and_is_kept() {
    let mut screen = open_on_trap();
    screen.state_mut().editor_mut().view.quantity = Quantity::Force;
    let mut shown = Vec::new();
    let start = Instant::now();
    while shown.is_empty() || screen.state().is_busy() {
        screen.step();
        let map = screen.state().shown().map.as_ref().unwrap();
        shown.push((map.quantity, map.width));
        assert!(start.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(1));
    }
    shown.dedup();
    let &[(Quantity::Rms, whole), (Quantity::Force, coarse), (Quantity::Force, last)] = &shown[..] else {
        panic!("the pressure stays until a coarse map of the force is there: {shown:?}");
    };
    assert!(last == whole && coarse < whole / 3, "{shown:?}");
    for (quantity, frames) in [(Quantity::Rms, 3), (Quantity::Force, 3)] {
        screen.state_mut().editor_mut().view.quantity = quantity;
        (0..frames).for_each(|_| screen.step());
        let map = screen.state().shown().map.as_ref().unwrap();
        assert_eq!((map.quantity, map.width), (quantity, whole), "nothing is made again");
        assert!(!screen.state().is_busy());
    }
}

#[test]
fn a_released_bead_flies_and_comes_to_rest() {
    let mut screen = open_on_trap();
    screen.state_mut().editor_mut().parts.levitation.form.typed = Some(AT + DVec3::X * 3e-4);
    rest(&mut screen);
    let release = |screen: &Screen| screen.state().editor().parts.flight.form;
    screen.get_by_role_and_label(Role::Button, "Release").scroll_to_me();
    rest(&mut screen);
    screen.get_by_role_and_label(Role::Button, "Release").click();
    screen.run_steps(2);
    rest(&mut screen);
    assert!(release(&screen).playing && screen.query_by_label_contains("Stays in the trap").is_some());
    let parts = &screen.state().editor().parts;
    let moments = &parts.flight.newest().unwrap().moments;
    assert!(moments[0].at.distance(AT + DVec3::X * 3e-4) < 1e-12 && moments.len() > 100);
    let time = release(&screen).time;
    screen.run_steps(2);
    assert!(release(&screen).time != time);
    key(&mut screen, Key::Space);
    rest(&mut screen);
    assert!(!release(&screen).playing && screen.run() <= 2, "paused");
    screen.get_by_label("Put away").click();
    rest(&mut screen);
    assert!(screen.state().editor().parts.flight.newest().is_none());
}
