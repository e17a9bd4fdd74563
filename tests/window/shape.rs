//! Shapes in the window: a quick drive during a drag, the best one at rest, and its figures.

use sonoglyph::solver::Solution;

use super::*;

fn solution(screen: &Screen) -> &Solution {
    screen.state().shown().solution.as_ref().expect("the scene is solved")
}

#[test]
fn a_shape_is_even_during_a_drag_and_has_low_side_lobes_at_rest() {
    let mut screen = open_best();
    let figures = solution(&screen).figures.expect("figures at rest");
    assert!(figures.evenness > 0.85 && figures.side_lobe < 0.6, "{figures:?}");
    // HIT, dragged at its I.
    let from = at(&screen, 0.0, 0.0);
    screen.hover_at(from);
    screen.step();
    screen.drag_at(from);
    screen.step();
    for step in 1..=10 {
        screen.hover_at(from + vec2(0.0, 4.0 * step as f32));
        screen.step();
        let held = solution(&screen);
        assert!(held.quality.evenness > 0.8, "step {step}: {}", held.quality.evenness);
    }
    assert!(solution(&screen).figures.is_none(), "no figures during a drag");
    let quick = solution(&screen).drive.clone();
    screen.drop_at(from + vec2(0.0, 40.0));
    rest(&mut screen);
    let moved = solution(&screen).figures.expect("figures at rest");
    assert!(moved.evenness > 0.85 && moved.side_lobe < 0.6, "{moved:?}");
    // The drive changes without a phase jump.
    let ahead = solution(&screen).drive.phases.iter().zip(&quick.phases);
    let turn: (f64, f64) =
        ahead.map(|(to, from)| (to - from).sin_cos()).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    assert!(turn.0.atan2(turn.1).abs() < 1e-9, "{turn:?}");
}

#[test]
fn the_solver_page_shows_a_shapes_figures_and_sets_quiet() {
    let mut screen = open_best();
    screen.get_by_label("Solver").click();
    rest(&mut screen);
    let figures = solution(&screen).figures.unwrap();
    screen.get_by_label(&format!("{:.0} %, {:.1} dB", 100.0 * figures.evenness, figures.ripple_db));
    screen.get_by_label("Peak side lobe");
    screen.get_by_label("Pressure along the strokes");
    let loud = figures.strength;
    screen.state_mut().editor_mut().document.scene.solver.quiet = 0.0;
    rest(&mut screen);
    let strongest = solution(&screen).figures.unwrap().strength;
    assert!(strongest > loud && (strongest - 1.0).abs() < 1e-3, "{strongest}, {loud} before");
    // Separate foci are not a shape.
    for target in &mut screen.state_mut().editor_mut().document.scene.targets {
        target.sampling = sonoglyph::scene::Sampling::Spacing(0.01);
    }
    rest(&mut screen);
    assert!(solution(&screen).figures.is_none());
    assert!(screen.query_by_label("Peak side lobe").is_none());
    assert!(screen.query_by_label("Pressure along the strokes").is_none());
}
