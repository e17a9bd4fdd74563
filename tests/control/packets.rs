//! Packets word by word: arguments of OSC, messages without type tags, and limits of Ultraino's commands.

use rosc::{OscPacket, OscType};
use sonoglyph::control::edit::Edit;
use sonoglyph::control::osc::{self, Word};
use sonoglyph::control::ultraino::Draft;

use crate::{floats, message, scene};

fn words(packet: &OscPacket) -> Result<Vec<Word>, String> {
    osc::words(&rosc::encoder::encode(packet).unwrap())
}

#[test]
fn added_targets_have_the_keys_of_their_file_with_one_value_or_several() {
    let word = |text: &str| OscType::String(text.to_owned());
    let [x, y, z] = floats([0.01, -0.02, 0.12]);
    let [across, up, on] = floats([0.0, 0.5, 1.0]);
    let circle = vec![
        word("circle"),
        x,
        y,
        z,
        word("normal"),
        across,
        up,
        on,
        word("radius"),
        OscType::Float(0.03),
        word("points"),
        OscType::Int(5),
        word("visible"),
        OscType::Bool(false),
    ];
    let text = vec![word("text"), word("text"), word("B"), word("points"), OscType::Int(6)];
    let corners = floats([0.0, 0.0, 0.1, 0.02, 0.0, 0.1, 0.02, 0.03, 0.12]);
    let path = std::iter::once(word("path")).chain(corners).collect();
    for (args, file) in [
        (
            circle,
            "kind = \"circle\"\nat = [0.01, -0.02, 0.12]\nnormal = [0, 0.5, 1]\nradius = 0.03\npoints = 5\n\
             visible = false\n",
        ),
        (path, "kind = \"path\"\nvertices = [[0, 0, 0.1], [0.02, 0, 0.1], [0.02, 0.03, 0.12]]\n"),
        (text, "kind = \"text\"\ntext = \"B\"\npoints = 6\n"),
    ] {
        let target = scene(&format!("format = 1\n[[target]]\n{file}")).targets.remove(0);
        let expected = Word::Edit(Edit::Add(Box::new(target)));
        assert_eq!(words(&message("target/add", &args)), Ok(vec![expected]), "{file}");
    }
}

#[test]
fn buttons_act_when_pressed_and_not_when_released() {
    use OscType::{Bool, Float, Inf, Int};
    let text = OscType::String("on".to_owned());
    let pressed: [&[OscType]; 8] = [
        &[],
        &[Float(1.0)],
        &[Float(0.3)],
        &[Int(127)],
        &[Bool(true)],
        &[Inf],
        &[text],
        &[Float(1.0), Float(0.0)],
    ];
    let released: [&[OscType]; 4] = [&[Float(0.0)], &[Int(0)], &[Bool(false)], &[Float(0.0), Float(1.0)]];
    for (address, word) in [
        ("clear", Word::Edit(Edit::Clear)),
        ("target/2/remove", Word::Edit(Edit::Remove(2))),
        ("state", Word::State),
    ] {
        for args in pressed {
            assert_eq!(words(&message(address, args)), Ok(vec![word.clone()]), "{address} {args:?}");
        }
        for args in released {
            assert_eq!(words(&message(address, args)), Ok(Vec::new()), "{address} {args:?}");
        }
    }
    for args in pressed.into_iter().chain(released) {
        assert_eq!(words(&message("stop", args)), Ok(vec![Word::Edit(Edit::Stop)]), "{args:?}");
    }
}

/// Old senders omit the type tags, but pad the address to a multiple of four bytes.
#[test]
fn a_part_of_a_message_without_type_tags_is_refused() {
    for (whole, word) in [
        (&b"/sonoglyph/stop\0"[..], Word::Edit(Edit::Stop)),
        (b"/sonoglyph/send\0", Word::Edit(Edit::Send(true))),
        (b"/sonoglyph/state\0\0\0\0", Word::State),
        (b"/sonoglyph/clear\0\0\0\0", Word::Edit(Edit::Clear)),
    ] {
        assert_eq!(osc::words(whole), Ok(vec![word]));
        for length in 0..whole.len() {
            assert!(osc::words(&whole[..length]).is_err(), "{:?}", &whole[..length]);
        }
    }
}

#[test]
fn bundles_are_nested_32_deep_at_most() {
    let nested = |depth: usize| {
        let bundle =
            |inner| OscPacket::Bundle(rosc::OscBundle { timetag: (0, 1).into(), content: vec![inner] });
        (0..depth).fold(message("stop", &[]), |packet, _| bundle(packet))
    };
    assert_eq!(words(&nested(32)), Ok(vec![Word::Edit(Edit::Stop)]));
    assert!(words(&nested(33)).is_err());
}

#[test]
fn ultraino_creates_at_most_1024_points_at_once() {
    let mut draft = Draft::default();
    assert_eq!(draft.take(b"create 1024"), Ok(None));
    let before = draft.clone();
    assert_eq!(draft.take(b"create 1025"), Err("create 1025: 1024 points at most".to_owned()));
    assert_eq!(draft, before);
    assert_eq!(draft.take(b"commit").unwrap().unwrap().len(), 1025, "the points, and the sound");
}
