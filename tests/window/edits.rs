//! Editing besides drawing: handles, the list, the clipboard, modulation, motion and listener.

use sonoglyph::scene::{Envelope, MotionPath, Sampling, Target, Tempo};

use super::*;

const AT: DVec3 = DVec3::new(0.0, 0.0, 0.1);

/// The window on these shapes alone, the first one selected.
fn open_with(shapes: &[Shape]) -> Screen {
    let mut screen = open();
    let editor = screen.state_mut().editor_mut();
    editor.document.scene.targets = shapes.iter().cloned().map(Target::new).collect();
    editor.selection = [0].into();
    rest(&mut screen);
    screen
}

fn point(x: f64) -> Shape {
    Shape::Point { at: AT + DVec3::X * x }
}

#[test]
fn shapes_are_resized_at_their_handles_as_one_undo_step() {
    let mut screen = open_with(&[Shape::Circle { at: AT, radius: 0.02 }]);
    let (from, to) = (at(&screen, 20.0, 0.0), at(&screen, 30.0, 0.0));
    drag(&mut screen, from, to);
    let Shape::Circle { at: centre, radius } = scene(&screen).targets[0].shape else { panic!("no circle") };
    assert!((radius - 0.03).abs() < 2e-4 && centre == AT, "{radius} {centre}");
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(scene(&screen).targets[0].shape, Shape::Circle { at: AT, radius: 0.02 });

    let mut screen = open_with(&[Shape::Rectangle { at: AT, width: 0.04, height: 0.02 }]);
    let (from, to) = (at(&screen, 20.0, 10.0), at(&screen, 30.0, 20.0));
    drag(&mut screen, from, to);
    let Shape::Rectangle { at: centre, width, height } = scene(&screen).targets[0].shape else {
        panic!("no rectangle")
    };
    assert!((width - 0.05).abs() < 4e-4 && (height - 0.03).abs() < 4e-4, "{width} {height}");
    assert!(
        centre.distance(AT + DVec3::new(0.005, 0.005, 0.0)) < 4e-4,
        "the opposite corner stays: {centre}"
    );
}

#[test]
fn a_hidden_target_stays_in_the_scene_and_is_silent() {
    let mut screen = open_with(&[point(-0.03), point(0.03)]);
    let loud = rms(&mut screen, 30.0, 0.0);
    screen.get_by_label("Target 2 is played").click();
    rest(&mut screen);
    assert!(!scene(&screen).targets[1].visible && scene(&screen).targets.len() == 2);
    assert_eq!(screen.state().shown().sound.as_ref().unwrap().foci.len(), 1);
    assert!(rms(&mut screen, 30.0, 0.0) < loud / 5.0);
    screen.get_by_label("Target 1 is played").click();
    rest(&mut screen);
    assert!(screen.state().shown().problem.as_ref().unwrap().contains("every target is hidden"));
    assert!(screen.state().shown().map.is_some(), "the last picture stays");
}

#[test]
fn the_list_is_reordered_with_the_pointer() {
    let mut screen = open_with(&[
        point(0.0),
        Shape::Circle { at: AT, radius: 0.02 },
        Shape::Triangle { at: AT, size: 0.03 },
    ]);
    let row = |screen: &Screen, name: &str| screen.get_by_label(name).rect();
    let (from, to) =
        (row(&screen, "1  Point").center(), row(&screen, "3  Triangle").center_bottom() - vec2(0.0, 3.0));
    drag(&mut screen, from, to);
    let kinds: Vec<_> = scene(&screen).targets.iter().map(|target| format!("{:?}", target.shape)).collect();
    let kinds: Vec<_> = kinds.iter().map(|kind| kind.split(' ').next().unwrap()).collect();
    assert_eq!(kinds, ["Circle", "Triangle", "Point"]);
    assert!(screen.state().editor().selection.contains(&2), "the moved target is selected");
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert!(matches!(scene(&screen).targets[0].shape, Shape::Point { .. }), "one undo step");
}

#[test]
fn targets_are_copied_cut_and_pasted() {
    let mut screen = open_with(&[point(-0.03), point(0.03)]);
    screen.event(Event::Cut);
    screen.step();
    let copied = screen.output().platform_output.commands.iter().find_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    });
    let copied = copied.expect("the clipboard has a text");
    rest(&mut screen);
    assert_eq!(scene(&screen).targets.len(), 1);
    screen.event(Event::Paste("no targets".to_owned()));
    rest(&mut screen);
    assert_eq!(scene(&screen).targets.len(), 1);
    screen.event(Event::Paste(copied));
    rest(&mut screen);
    assert_eq!(scene(&screen).targets.len(), 2);
    let Shape::Point { at } = scene(&screen).targets[1].shape else { panic!("no point") };
    assert!(at.distance(AT + DVec3::new(-0.02, -0.01, 0.0)) < 1e-12, "displaced from the original: {at}");
    assert!(screen.state().editor().selection.contains(&1));
}

#[test]
fn an_outline_is_a_continuous_stroke_or_separate_foci() {
    let mut screen = open_with(&[Shape::Circle { at: AT, radius: 0.02 }, point(0.0)]);
    let samples = |screen: &Screen| {
        let foci = &screen.state().shown().sound.as_ref().unwrap().foci;
        let of_stroke = foci.iter().filter(|focus| !focus.is_separate()).count();
        (of_stroke, foci.len() - of_stroke)
    };
    assert_eq!(scene(&screen).targets[0].sampling, Sampling::Continuous);
    assert_eq!(samples(&screen), (59, 1), "126 mm in steps of 2.1 mm");
    assert!(screen.state().shown().warnings.is_empty(), "{:?}", screen.state().shown().warnings);

    pick(&mut screen, "Stroke", "Spacing");
    type_in(&mut screen, "Focus spacing", "8");
    assert_eq!(scene(&screen).targets[0].sampling, Sampling::Spacing(0.008));
    assert_eq!(samples(&screen), (0, 17));
    pick(&mut screen, "Stroke", "Count");
    type_in(&mut screen, "Foci", "11");
    assert_eq!((scene(&screen).targets[0].sampling, samples(&screen)), (Sampling::Points(11), (0, 12)));
    pick(&mut screen, "Stroke", "Continuous");
    assert_eq!((scene(&screen).targets[0].sampling, samples(&screen)), (Sampling::Continuous, (59, 1)));
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(scene(&screen).targets[0].sampling, Sampling::Points(11));
}

#[test]
fn a_stroke_is_drawn_as_a_line_without_a_dot_for_each_sample() {
    let mut screen = open_with(&[Shape::Circle { at: AT, radius: 0.02 }]);
    screen.state_mut().editor_mut().selection.clear();
    rest(&mut screen);
    let circles = |screen: &mut Screen| {
        screen.run_steps(1);
        let shapes = &screen.output().shapes;
        let is_dot = |shape: &egui::Shape| matches!(shape, egui::Shape::Circle(circle) if circle.stroke.color == sonoglyph::ui::theme::MARK);
        shapes.iter().filter(|clipped| is_dot(&clipped.shape)).count()
    };
    assert_eq!(circles(&mut screen), 0);
    screen.state_mut().editor_mut().document.scene.targets[0].sampling = Sampling::Points(9);
    rest(&mut screen);
    assert_eq!(circles(&mut screen), 9);
}

#[test]
fn modulation_and_listener_can_be_edited() {
    let mut screen = open_with(&[point(0.0)]);
    screen.get_by_label("Motion").click();
    rest(&mut screen);
    pick(&mut screen, "Amplitude modulation", "sine");
    assert_eq!(scene(&screen).modulation.shape, Envelope::Sine);
    type_in(&mut screen, "Frequency", "150");
    type_in(&mut screen, "Modulation depth", "80");
    assert_eq!((scene(&screen).modulation.frequency, scene(&screen).modulation.depth), (150.0, 0.8));
    screen.get_by_label("Scene").click();
    rest(&mut screen);
    screen.get_by_label("Listener").click();
    rest(&mut screen);
    screen.get_by_label("Exposure at a listener").click();
    rest(&mut screen);
    type_in(&mut screen, "Ear y", "-400");
    assert_eq!(scene(&screen).listener.as_ref().unwrap().at.y, -0.4);
    assert!(screen.query_by_label_contains("dB SPL").is_some());
}

#[test]
fn paths_through_points_and_steps_can_be_edited() {
    let mut screen = open_with(&[point(-0.02), point(0.02)]);
    screen.get_by_label("Motion").click();
    rest(&mut screen);
    pick(&mut screen, "Path", "points");
    assert_eq!(scene(&screen).motion.points.len(), 3);
    screen.get_by_label("Add a point after 1").click();
    rest(&mut screen);
    type_in(&mut screen, "Point 2 y", "7");
    screen.get_by_label("Remove point 3").click();
    rest(&mut screen);
    let points = &scene(&screen).motion.points;
    assert!(points.len() == 3 && (points[1].y - 0.007).abs() < 1e-12, "{points:?}");
    assert!(screen.state().shown().problem.is_none() && screen.state().shown().round.is_some());

    pick(&mut screen, "Path", "steps");
    let steps: Vec<_> = scene(&screen).targets.iter().map(|target| target.step).collect();
    assert_eq!(steps, [Some(0), Some(1)]);
    let round = screen.state().shown().round.as_ref().unwrap();
    assert!(round.frames.iter().all(|frame| frame.foci.len() == 1), "one focus per frame");
    pick(&mut screen, "Path", "none");
    assert!(scene(&screen).targets.iter().all(|target| target.step.is_none()));
    assert_eq!(scene(&screen).motion.path, MotionPath::None);
}

#[test]
fn foci_run_along_the_drawing_at_a_constant_speed_or_rate() {
    let mut screen = open_with(&[Shape::Rectangle { at: AT, width: 0.04, height: 0.06 }, point(0.0)]);
    screen.get_by_label("Motion").click();
    rest(&mut screen);
    pick(&mut screen, "Path", "outline");
    assert_eq!(scene(&screen).motion.tempo, Tempo::Speed(6.0), "200 mm at 6 m/s: 30 times a second");
    assert!(screen.query_by_label_contains("1920 per second").is_some());
    type_in(&mut screen, "Running foci", "2");
    type_in(&mut screen, "Frames", "12");
    let round = screen.state().shown().round.clone().unwrap();
    assert_eq!(round.frames.len(), 12);
    assert!(round.frames.iter().all(|frame| frame.foci.len() == 3 && frame.foci[0].position == AT));
    type_in(&mut screen, "Rate", "20");
    assert_eq!(scene(&screen).motion.tempo, Tempo::Rate(20.0));
    type_in(&mut screen, "Speed", "8");
    assert_eq!(scene(&screen).motion.tempo, Tempo::Speed(8.0));
    assert!(screen.query_by_label_contains("480 per second").is_some());
    screen.get_by_role_and_label(egui::accesskit::Role::Button, "Play").click();
    screen.run_steps(3);
    assert_eq!(screen.state().shown().sound.as_ref().unwrap().foci.len(), 3, "a frame is shown");
    pick(&mut screen, "Path", "none");
    assert!(screen.state().shown().problem.is_none() && screen.state().shown().round.is_none());
}

#[test]
fn a_target_gets_its_own_motion_without_a_new_solution_at_rest() {
    let mut screen = open_with(&[point(-0.02), point(0.02)]);
    let solution = screen.state().shown().solution.clone().unwrap();
    screen.get_by_label("Own motion").click();
    rest(&mut screen);
    assert_eq!(scene(&screen).targets[0].motion.as_ref().unwrap().path, MotionPath::None);
    pick(&mut screen, "Path", "circle");
    type_in(&mut screen, "Rate", "10");
    type_in(&mut screen, "Frames", "6");
    screen.get_by_label("Motion").click();
    rest(&mut screen);
    assert!(screen.query_by_label_contains("1 target has its own motion").is_some());
    let round = screen.state().shown().round.clone().unwrap();
    let places = |index: usize| round.frames.iter().map(move |frame| frame.foci[index].position);
    assert!(round.frames.len() == 6 && places(1).all(|at| at == AT + DVec3::X * 0.02));
    assert!(places(0).all(|at| (at.distance(AT - DVec3::X * 0.02) - 0.015).abs() < 1e-12));
    // The scene's motion defines the cycle, and the target's motion fits a whole number of times.
    pick(&mut screen, "Path", "line");
    screen.get_by_label("Scene").click();
    rest(&mut screen);
    assert!(screen.query_by_label("2 times a cycle: 10.00 Hz").is_some());
    assert!(std::sync::Arc::ptr_eq(&solution, screen.state().shown().solution.as_ref().unwrap()));
    screen.get_by_label("Own motion").click();
    rest(&mut screen);
    assert_eq!(scene(&screen).targets[0].motion, None);
}

#[test]
fn a_target_gets_its_own_modulation_and_the_window_plays_the_frames() {
    let mut screen = open_with(&[point(-0.02), point(0.02)]);
    let solution = screen.state().shown().solution.clone().unwrap();
    screen.get_by_label("Own modulation").click();
    rest(&mut screen);
    assert_eq!(scene(&screen).targets[0].modulation, Some(scene(&screen).modulation.clone()));
    pick(&mut screen, "Amplitude modulation", "sine");
    type_in(&mut screen, "Frequency", "2000");
    type_in(&mut screen, "Modulation depth", "60");
    let own = scene(&screen).targets[0].modulation.clone().unwrap();
    assert_eq!((own.shape, own.frequency, own.depth), (Envelope::Sine, 2000.0, 0.6));
    screen.get_by_label("Motion").click();
    rest(&mut screen);
    assert!(screen.query_by_label_contains("1 target has its own modulation").is_some());
    assert!(screen.query_by_label_contains("Heard at 1 m").is_some());
    let round = screen.state().shown().round.clone().unwrap();
    // The other follows the scene's 200 Hz.
    assert!(round.frames.len() == 200, "{}", round.frames.len());
    let least = |index: usize| {
        let all = round.frames.iter().map(|frame| frame.pressures[index].norm());
        let most = all.clone().fold(0.0, f64::max);
        all.fold(f64::INFINITY, f64::min) / most
    };
    assert!((least(0) - 0.4).abs() < 0.02 && least(1) < 0.02, "{} {}", least(0), least(1));
    assert!(std::sync::Arc::ptr_eq(&solution, screen.state().shown().solution.as_ref().unwrap()));
    screen.get_by_label("Scene").click();
    rest(&mut screen);
    screen.get_by_label("Own modulation").click();
    rest(&mut screen);
    assert_eq!(scene(&screen).targets[0].modulation, None);
}

#[test]
fn a_focus_dragged_upwards_in_an_upright_plane_follows_the_pointer() {
    let mut screen = open_with(&[point(0.0)]);
    for (cut, across) in [("XZ", 12.0), ("YZ", -8.0)] {
        screen.get_by_label(cut).click();
        rest(&mut screen);
        let whole = lens(&screen);
        let z = |screen: &Screen| match scene(screen).targets[0].shape {
            Shape::Point { at } => at.z * 1e3,
            _ => panic!("no point"),
        };
        let (from, to) = (at(&screen, 0.0, z(&screen)), at(&screen, across, 170.0));
        drag(&mut screen, from, to);
        assert!((z(&screen) - 170.0).abs() < 1.5, "{} mm in {cut}", z(&screen));
        assert_eq!(lens(&screen).window, whole.window, "it stays in view");
        key(&mut screen, Key::ArrowUp);
        assert_eq!(lens(&screen).window, whole.window, "a key does not move the view");
        key(&mut screen, Key::Num0);
        assert!(lens(&screen).window.scale > whole.window.scale, "the whole is now larger");
        press(&mut screen, Modifiers::COMMAND, Key::Z);
        press(&mut screen, Modifiers::COMMAND, Key::Z);
        key(&mut screen, Key::Num0);
    }
}
