//! What no hand would do: commands without pattern, numbers without sense, far too much of everything.

use super::*;

/// Numbers without pattern, the same every time.
struct Dice(u64);

impl Dice {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % count
    }

    fn place(&mut self, rect: Rect) -> Pos2 {
        let part = |dice: &mut Self| dice.below(1000) as f32 / 1000.0;
        rect.min + vec2(part(self) * rect.width(), part(self) * rect.height())
    }
}

#[test]
fn hundreds_of_random_commands_do_no_harm_and_can_all_be_taken_back() {
    let mut screen = open();
    let first = scene(&screen).clone();
    let window = Rect::from_min_size(Pos2::ZERO, vec2(1280.0, 800.0));
    let mut dice = Dice(7);
    for _ in 0..300 {
        let canvas =
            screen.query_by_label("Canvas: the field on the plane").map_or(window, |node| node.rect());
        match dice.below(10) {
            0..4 => {
                let tool = Tool::ALL[dice.below(Tool::ALL.len())];
                screen.key_press(tool.key());
                screen.step();
                let (from, to) = (dice.place(canvas), dice.place(canvas));
                drag_briskly(&mut screen, from, to);
            }
            4 => {
                let keys =
                    [Key::Delete, Key::ArrowUp, Key::Enter, Key::Num1, Key::Num2, Key::Num3, Key::M, Key::K];
                screen.key_press(keys[dice.below(keys.len())]);
            }
            5 => {
                let keys = [Key::Z, Key::Y, Key::D, Key::A];
                screen.key_press_modifiers(Modifiers::COMMAND, keys[dice.below(keys.len())]);
            }
            6 => {
                let letters = ["H", "é", "7", "木", " "];
                screen.event(Event::Text(letters[dice.below(letters.len())].to_owned()));
            }
            7 => {
                let labels =
                    ["Scene", "Solver", "Drive", "Liquid", "XY", "XZ", "YZ", "Own", "dB", "Lock range"];
                if let Some(node) = screen.query_by_label(labels[dice.below(labels.len())]) {
                    node.click();
                }
            }
            // Anywhere beside the canvas, but for the menu: it leads out of the window.
            8 => {
                let panel = Rect::from_min_max(Pos2::new(canvas.right(), 70.0), Pos2::new(1270.0, 760.0));
                let (from, to) = (dice.place(panel), dice.place(panel));
                drag_briskly(&mut screen, from, to);
            }
            _ => {
                let wheel = vec2(0.0, dice.below(400) as f32 - 200.0);
                screen.hover_at(dice.place(canvas));
                screen.event(Event::MouseWheel {
                    unit: egui::MouseWheelUnit::Point,
                    delta: wheel,
                    source: egui::MouseWheelSource::Wheel,
                    phase: egui::TouchPhase::Move,
                    modifiers: Modifiers::NONE,
                });
            }
        }
        screen.step();
        // More foci than that take their time, and that is tried elsewhere.
        let targets = &mut screen.state_mut().editor_mut().document.scene.targets;
        targets.truncate(6);
    }
    screen.state_mut().editor_mut().dialog = None;
    key(&mut screen, Key::Escape);
    key(&mut screen, Key::Escape);
    let last = scene(&screen).clone();
    assert_ne!(last, first);
    let editor = screen.state_mut().editor_mut();
    while editor.document.can_undo() {
        editor.undo();
    }
    assert_eq!(editor.document.scene, first);
    while editor.document.can_redo() {
        editor.redo();
    }
    assert_eq!(editor.document.scene, last);
}
