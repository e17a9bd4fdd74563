//! The 3D view: camera, selecting and dragging targets in space, slices and the clipped box.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use egui::PointerButton;
use sonoglyph::scene::{Target, outline};
use sonoglyph::ui::space::{Seen, Stage};

use super::*;

const CANVAS: &str = "Canvas: the scene in space";
const AT: DVec3 = DVec3::new(0.01, -0.005, 0.1);

fn open_in_space() -> Screen {
    let mut screen = open();
    screen.state_mut().editor_mut().document.scene.targets = vec![Target::new(Shape::Point { at: AT })];
    rest(&mut screen);
    screen.state_mut().editor_mut().document.settle();
    screen.get_by_label("3D").click();
    rest(&mut screen);
    screen
}

fn stage(screen: &Screen) -> Stage {
    screen.state().shown().space.as_ref().expect("the view has a picture").stage.clone()
}

fn place(screen: &Screen, point: DVec3) -> Pos2 {
    stage(screen).screen(point).unwrap()
}

fn centre(screen: &Screen) -> DVec3 {
    outline::centre(&scene(screen).targets[0].shape)
}

/// Asserts that the scene was not edited since the view was opened.
fn undo_leads_to_the_example(screen: &mut Screen) {
    press(screen, Modifiers::COMMAND, Key::Z);
    assert!(
        matches!(scene(screen).targets[0].shape, Shape::Text { .. }),
        "the camera is not part of the scene"
    );
}

/// A place without scenery: the upper left corner, below the texts.
fn beside(screen: &Screen) -> Pos2 {
    screen.get_by_label(CANVAS).rect().left_top() + vec2(30.0, 60.0)
}

#[test]
fn the_view_is_fine_at_rest_and_closes_with_the_button() {
    let mut screen = open_in_space();
    let picture = screen.state().shown().space.as_ref().unwrap();
    assert!(!picture.is_coarse && picture.peak > 100.0, "{picture:?}");
    screen.get_by_label("Map").click();
    rest(&mut screen);
    assert!(screen.state().shown().space.is_none() && screen.state().shown().map.is_some());
    key(&mut screen, Key::F3);
    assert!(screen.state().shown().space.is_some());
}

#[test]
fn a_moving_view_is_coarse_and_a_resting_one_is_not_redrawn() {
    let mut screen = open_in_space();
    let from = beside(&screen);
    screen.hover_at(from);
    screen.step();
    screen.drag_at(from);
    screen.step();
    screen.hover_at(from + vec2(60.0, 20.0));
    screen.step();
    assert!(screen.state().shown().space.as_ref().unwrap().is_coarse, "while it is turned");
    screen.drop_at(from + vec2(60.0, 20.0));
    rest(&mut screen);
    let picture = screen.state().shown().space.as_ref().unwrap();
    assert!(!picture.is_coarse);
    let asked = Arc::new(AtomicU64::new(0));
    let heard = Arc::clone(&asked);
    screen.ctx.set_request_repaint_callback(move |info| {
        heard.fetch_max(info.current_cumulative_pass_nr + 1, Ordering::Relaxed);
    });
    screen.step();
    assert!(
        asked.load(Ordering::Relaxed) < screen.ctx.cumulative_pass_nr(),
        "an idle view requests no frames"
    );
    assert!(!screen.state().is_busy());
}

#[test]
fn the_camera_turns_pans_zooms_and_returns_home() {
    let mut screen = open_in_space();
    let home = stage(&screen).camera;
    let before = scene(&screen).clone();
    let from = beside(&screen);
    drag(&mut screen, from, from + vec2(120.0, 40.0));
    let turned = stage(&screen).camera;
    assert!(
        turned.azimuth != home.azimuth && turned.elevation > home.elevation && turned.target == home.target
    );

    screen.hover_at(from);
    screen.step();
    for (pos, pressed) in [(from, true), (from + vec2(50.0, 0.0), true), (from + vec2(50.0, 0.0), false)] {
        screen.hover_at(pos);
        if pos == from || !pressed {
            let button = PointerButton::Middle;
            screen.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
        }
        screen.step();
    }
    rest(&mut screen);
    let panned = stage(&screen).camera;
    assert!(panned.target != turned.target && panned.azimuth == turned.azimuth);

    let middle = screen.get_by_label(CANVAS).rect().center();
    turn_wheel(&mut screen, middle);
    assert!(stage(&screen).camera.span < 0.9 * panned.span);

    screen.get_by_label("Home").click();
    rest(&mut screen);
    assert_eq!(stage(&screen).camera, home);
    screen.get_by_label("Top").click();
    rest(&mut screen);
    assert!((stage(&screen).camera.elevation - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!(*scene(&screen), before);
    undo_leads_to_the_example(&mut screen);
}

#[test]
fn a_target_is_selected_by_a_click_and_dragged_along_an_axis_or_a_plane() {
    let mut screen = open_in_space();
    let at = place(&screen, AT);
    click(&mut screen, at);
    assert_eq!(screen.state().editor().selection, BTreeSet::from([0]));
    assert_eq!(centre(&screen), AT);

    // The upward arrow, by 30 mm.
    let grip = |screen: &Screen, up: f64| {
        let from = place(screen, centre(screen));
        let tip = place(screen, centre(screen) + DVec3::Z * 0.01);
        let grip = from + (tip - from).normalized() * 50.0;
        (grip, grip + (tip - from) * (up / 0.01) as f32)
    };
    let (from, to) = grip(&screen, 0.03);
    drag(&mut screen, from, to);
    let moved = centre(&screen);
    assert!((moved - AT).truncate().length() < 1e-9, "{moved}");
    assert!((moved.z - AT.z - 0.03).abs() < 2e-3, "{moved}");
    let peak = screen.state().shown().space.as_ref().unwrap().peak;
    assert!(peak > 100.0 && screen.state().shown().problem.is_none());
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(centre(&screen), AT, "a drag is one undo step");

    // Dragged itself, the target stays at its height.
    let (from, to) = (place(&screen, AT), place(&screen, AT + DVec3::new(0.02, 0.01, 0.0)));
    drag(&mut screen, from, to);
    let moved = centre(&screen);
    assert!(moved.distance(AT + DVec3::new(0.02, 0.01, 0.0)) < 2e-3 && moved.z == AT.z, "{moved}");
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(centre(&screen), AT);
}

#[test]
fn a_drawing_tool_switches_to_the_map() {
    let mut screen = open();
    key(&mut screen, Key::C);
    key(&mut screen, Key::F3);
    assert_eq!(screen.state().editor().tool, Tool::Select, "no drawing in space");
    assert!(screen.state().shown().space.is_some());
    key(&mut screen, Key::C);
    assert!(!screen.state().editor().space.is_on && screen.state().shown().map.is_some());
    assert_eq!(screen.state().editor().tool, Tool::Circle);
}

#[test]
fn escape_cancels_a_drag_in_space() {
    let mut screen = open_in_space();
    let (from, to) = (place(&screen, AT), place(&screen, AT + DVec3::X * 0.03));
    drag_and_hold(&mut screen, from, to);
    assert!(centre(&screen).distance(AT) > 0.01);
    key(&mut screen, Key::Escape);
    assert_eq!(centre(&screen), AT);
    screen.drop_at(to);
    rest(&mut screen);
    assert_eq!(centre(&screen), AT);
}

#[test]
fn slices_and_the_clipped_box_are_dragged_by_their_knobs() {
    let mut screen = open_in_space();
    screen.get_by_label("Slice z").click();
    rest(&mut screen);
    let height = screen.state().editor().space.slices[2].unwrap();
    let Stage { clip, .. } = stage(&screen);
    let knob = |height: f64| DVec3::new(clip.high().x, clip.low().y, height);
    let (from, to) = (place(&screen, knob(height)), place(&screen, knob(height - 0.03)));
    drag(&mut screen, from, to);
    let moved = screen.state().editor().space.slices[2].unwrap();
    assert!((moved - (height - 0.03)).abs() < 2e-3, "{moved}");

    screen.get_by_label("Clip").click();
    rest(&mut screen);
    let Stage { clip, .. } = stage(&screen);
    let top = |height: f64| DVec3::new(clip.centre.x, clip.centre.y, height);
    let (from, to) = (place(&screen, top(clip.high().z)), place(&screen, top(clip.centre.z)));
    drag(&mut screen, from, to);
    let clipped = stage(&screen).clip;
    assert!((clipped.high().z - clip.centre.z).abs() < 3e-3 && clipped.low() == clip.low(), "{clipped:?}");
    undo_leads_to_the_example(&mut screen);
}

#[test]
fn the_surface_level_and_the_projection_are_chosen_in_the_view_bar() {
    let mut screen = open_in_space();
    screen.get_by_label("Projection").click();
    rest(&mut screen);
    assert_eq!(screen.state().editor().space.seen, Seen::Projection);
    screen.get_by_label("Surface").click();
    rest(&mut screen);
    assert_eq!(screen.state().editor().space.seen, Seen::Surface);
    screen.state_mut().editor_mut().space.level = -12.0;
    rest(&mut screen);
    assert!(!screen.state().shown().space.as_ref().unwrap().is_coarse);
}

#[test]
fn an_idle_view_draws_no_frames_of_hidden_waves() {
    let mut screen = open();
    key(&mut screen, Key::Num5);
    screen.run_steps(5);
    assert!(screen.state().editor().oscillation.playing);
    key(&mut screen, Key::F3);
    rest(&mut screen);
    assert!(screen.run() <= 2, "an idle window requests no frames");
    key(&mut screen, Key::Num1);
    assert!(!screen.state().editor().space.is_on, "a quantity is one of the map");
}
