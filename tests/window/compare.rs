//! Two maps side by side: their differences in method, levels and plane, one colour scale, pointer and zoom.

use egui::accesskit::Role;
use sonoglyph::scene::Method;
use sonoglyph::ui::beside::Beside;

use super::*;

fn choose(screen: &mut Screen, label: &str) {
    screen.get_by_role_and_label(Role::Button, label).click();
    rest(screen);
}

fn switch(screen: &mut Screen) {
    screen.get_by_role_and_label(Role::CheckBox, "Compare").click();
    rest(screen);
}

fn comparing() -> Screen {
    let mut screen = open_best();
    switch(&mut screen);
    screen
}

fn beside(screen: &Screen) -> &Beside {
    screen.state().shown().beside.as_ref().unwrap()
}

#[test]
fn another_method_is_compared_on_the_same_colour_scale() {
    let mut screen = comparing();
    let (own, other) = (screen.state().shown().map.as_ref().unwrap(), beside(&screen).map.as_ref().unwrap());
    let range = Some(f64::from(own.largest.max(other.largest) as f32));
    assert_eq!((own.full, other.full), (range, range));
    assert_ne!(own.largest, other.largest);
    assert_eq!((own.window, own.rect.size()), (other.window, other.rect.size()));
    assert!(own.error < 1e-3 && other.error < 1e-3);
    let mut alone = scene(&screen).clone();
    alone.solver.method = Method::Naive;
    let drive = sonoglyph::solver::solve(&alone).unwrap().drive;
    assert_eq!(beside(&screen).sound.as_ref().unwrap().drive(), &drive);
    // Switched off, the second map is not computed, and the first has its own range again.
    switch(&mut screen);
    assert!(screen.state().shown().beside.is_none());
    assert_eq!(screen.state().shown().map.as_ref().unwrap().full, None);
    assert!(screen.run() <= 2, "an idle window requests no frames");
}

#[test]
fn an_idle_comparison_requests_no_frames() {
    let mut screen = comparing();
    let work = screen.state().work();
    screen.run_steps(5);
    assert_eq!(screen.state().work(), work);
    assert!(screen.run() <= 2);
}

#[test]
fn the_difference_is_of_both_maps() {
    let mut screen = comparing();
    choose(&mut screen, "Difference");
    let largest = beside(&screen).difference.as_ref().unwrap().largest;
    let (own, other) = {
        let (_, own) = screen.state_mut().numbers().unwrap();
        let shown = screen.state().shown();
        (own, shown.beside.as_ref().unwrap().map.as_ref().unwrap().largest)
    };
    let most = own.iter().copied().fold(0.0, f32::max);
    assert!(largest > 0.0 && largest <= f64::from(most).max(other), "{largest}");
    // A method compared with itself.
    screen.get_by_role_and_label(Role::ComboBox, "Second method").click();
    rest(&mut screen);
    let item = screen.get_all_by_label("best (levelled Gauss-Newton)").last().unwrap();
    item.click();
    rest(&mut screen);
    assert_eq!(beside(&screen).difference.as_ref().unwrap().largest, 0.0);
}

#[test]
fn a_drive_on_few_levels_is_compared_with_the_ideal_one() {
    let mut screen = comparing();
    choose(&mut screen, "Phase levels");
    let ideal = screen.state().shown().sound.as_ref().unwrap().drive().clone();
    assert_eq!(beside(&screen).sound.as_ref().unwrap().drive(), &ideal.at_levels(16));
    assert!(screen.query_by_label_contains("solved").is_none());
}

#[test]
fn another_plane_shares_the_zoom_and_the_pointer() {
    let mut screen = comparing();
    choose(&mut screen, "Plane");
    let second = beside(&screen).map.as_ref().unwrap();
    assert_eq!(second.axes.y, DVec3::Z);
    let right = screen.get_by_label("Second map").rect();
    turn_wheel(&mut screen, right.center());
    let (own, other) = (screen.state().shown().map.as_ref().unwrap(), beside(&screen).map.as_ref().unwrap());
    assert_eq!(own.window.scale, other.window.scale);
    assert_eq!(own.window.centre.x, other.window.centre.x);
    assert!(screen.state().editor().view.window.is_some());
    // Back to a comparison of methods, both maps have the same window.
    choose(&mut screen, "Method");
    let (own, other) = (screen.state().shown().map.as_ref().unwrap(), beside(&screen).map.as_ref().unwrap());
    assert_eq!(own.window, other.window);
}
