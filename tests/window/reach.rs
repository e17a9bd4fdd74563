//! All inputs have a name and can be reached by keyboard.

use std::collections::BTreeSet;

use egui::accesskit::{NodeId, Role};
use egui_kittest::kittest::NodeT;

use super::*;

/// Whether a widget takes input.
fn is_input(role: Role) -> bool {
    matches!(
        role,
        Role::Button
            | Role::CheckBox
            | Role::ColorWell
            | Role::ComboBox
            | Role::Link
            | Role::MenuItem
            | Role::RadioButton
            | Role::Slider
            | Role::SpinButton
            | Role::TextInput
            | Role::MultilineTextInput
            | Role::Canvas
    )
}

/// Role and position of inputs without a name.
fn unnamed<State>(screen: &Harness<'_, State>) -> Vec<String> {
    let nodes = screen.root().children_recursive();
    let is_unnamed = |node: &egui_kittest::Node<'_>| {
        let node = node.accesskit_node();
        is_input(node.role()) && node.label().is_none_or(|label| label.trim().is_empty())
    };
    nodes
        .filter(is_unnamed)
        .map(|node| format!("{:?} at {:?}", node.accesskit_node().role(), node.rect()))
        .collect()
}

#[test]
fn an_input_without_a_name_is_found() {
    let with_letters = Harness::builder().with_context_setup(sonoglyph::ui::theme::install);
    let with_letters = with_letters.with_accessibility_check(false);
    let screen = with_letters.build_ui(|ui| {
        let label = ui.label("Size");
        ui.add(egui::DragValue::new(&mut 1.0)).labelled_by(label.id);
        ui.add(egui::DragValue::new(&mut 2.0));
        ui.checkbox(&mut true, "");
        let _ = ui.button("Close");
    });
    let found = unnamed(&screen);
    assert!(
        found.len() == 2 && found[0].contains("SpinButton") && found[1].contains("CheckBox"),
        "{found:?}"
    );
}

#[test]
fn no_input_is_without_a_name() {
    let mut screen = open();
    let mut found = Vec::new();
    screen.state_mut().editor_mut().selection = [0].into();
    screen.state_mut().editor_mut().document.scene.motion.path = sonoglyph::scene::MotionPath::Points;
    screen.state_mut().editor_mut().document.scene.motion.points = vec![DVec3::ZERO, DVec3::X * 0.01];
    screen.state_mut().editor_mut().document.scene.modulation.shape = sonoglyph::scene::Envelope::Sine;
    let points = screen.state().editor().document.scene.motion.clone();
    screen.state_mut().editor_mut().document.scene.targets[0].motion = Some(points);
    screen.state_mut().editor_mut().view.section = true;
    screen.state_mut().editor_mut().view.full = Some(100.0);
    screen.state_mut().editor_mut().tool = Tool::Brush;
    for panel in ["Solver", "Drive", "Liquid", "Motion", "Felt", "Device", "Scene"] {
        page(&screen, panel).unwrap().click();
        rest(&mut screen);
        found.extend(unnamed(&screen).into_iter().map(|what| format!("{panel}: {what}")));
    }
    let outline = sonoglyph::scene::MotionPath::Outline;
    screen.state_mut().editor_mut().document.scene.motion.path = outline;
    screen.state_mut().editor_mut().document.scene.targets[0].motion.as_mut().unwrap().path = outline;
    for panel in ["Motion", "Scene"] {
        page(&screen, panel).unwrap().click();
        rest(&mut screen);
        found.extend(unnamed(&screen).into_iter().map(|what| format!("{panel}, outline: {what}")));
    }
    for part in ["Listener", "Exposure at a listener", "Array", "Air"] {
        screen.get_by_label(part).scroll_to_me();
        rest(&mut screen);
        screen.get_by_label(part).click();
        rest(&mut screen);
        found.extend(unnamed(&screen).into_iter().map(|what| format!("{part}: {what}")));
    }
    for menu in ["File", "Edit", "Examples", "Export", "Help"] {
        screen.get_by_label(menu).click();
        rest(&mut screen);
        found.extend(unnamed(&screen).into_iter().map(|what| format!("{menu}: {what}")));
        key(&mut screen, Key::Escape);
    }
    for purpose in [Purpose::Open, Purpose::Import] {
        let text = String::new();
        screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text });
        rest(&mut screen);
        found.extend(unnamed(&screen).into_iter().map(|what| format!("{purpose:?}: {what}")));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_keyboard_reaches_every_input() {
    let mut screen = open();
    screen.state_mut().editor_mut().selection = [0].into();
    let outline = sonoglyph::scene::Motion {
        path: sonoglyph::scene::MotionPath::Outline,
        frames: 4,
        ..sonoglyph::scene::Motion::default()
    };
    screen.state_mut().editor_mut().document.scene.targets[0].motion = Some(outline);
    screen.state_mut().editor_mut().tool = Tool::Brush;
    rest(&mut screen);
    for panel in ["Scene", "Solver", "Liquid", "Motion", "Felt"] {
        page(&screen, panel).unwrap().click();
        rest(&mut screen);
        let reachable = |screen: &Screen| -> BTreeSet<NodeId> {
            let nodes = screen.root().children_recursive();
            let is_open = |node: &egui_kittest::Node<'_>| {
                is_input(node.accesskit_node().role()) && !node.accesskit_node().is_disabled()
            };
            nodes.filter(is_open).map(|node| node.accesskit_node().locate().0).collect()
        };
        let mut left = reachable(&screen);
        assert!(left.len() > 20, "{}", left.len());
        for _ in 0..2 * left.len() {
            screen.key_press(Key::Tab);
            screen.step();
            let nodes = screen.root().children_recursive();
            let focused = nodes.filter(|node| node.accesskit_node().is_focused());
            for node in focused.map(|node| node.accesskit_node().locate().0).collect::<Vec<_>>() {
                left.remove(&node);
            }
            if left.is_empty() {
                break;
            }
        }
        let names: Vec<_> = screen
            .root()
            .children_recursive()
            .filter(|node| left.contains(&node.accesskit_node().locate().0))
            .map(|node| format!("{:?} {:?}", node.accesskit_node().role(), node.accesskit_node().label()))
            .collect();
        assert!(names.is_empty(), "{panel}: Tab does not reach {names:?}");
    }
}
