//! Commands of every protocol edit the scene as its file would, atomically.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rosc::OscType;
use serde_json::json;
use sonoglyph::control::desk::Desk;
use sonoglyph::control::edit::{Edit, Wish};
use sonoglyph::control::live::Live;
use sonoglyph::control::report::Report;
use sonoglyph::field::{Evaluator, Quantity, Request, Stages};
use sonoglyph::scene::{Curve, Envelope, Modulation, Scene, Skin, Wave, Waveform};
use sonoglyph::solver::{self, Solution};
use tungstenite::Message;

use crate::{Serving, TWO, eventually, floats, message, scene};

#[test]
fn osc_moves_types_adds_and_removes_as_the_file_would() {
    let serving = Serving::local(TWO);
    let osc = serving.udp("osc");
    serving.has_foci_of(TWO);
    osc.osc("target/1/at", &floats([0.01, -0.02, 0.12]));
    osc.osc("target/1/pressure", &[OscType::Double(2.5)]);
    osc.osc("target/2/text", &[OscType::String("B".to_owned())]);
    osc.osc("target/2/angle", &[OscType::Int(1)]);
    let text = "format = 1\n[[target]]\nat = [0.01, -0.02, 0.12]\npressure = 2.5\n[[target]]\nkind = \"text\"\ntext = \"B\"\n\
                angle = 1\npoints = 6\n";
    serving.has_foci_of(text);
    let word = |text: &str| OscType::String(text.to_owned());
    let [x, y, z] = floats([0.0, 0.0, 0.1]);
    osc.osc(
        "target/add",
        &[word("circle"), x, y, z, word("radius"), OscType::Float(0.03), word("points"), OscType::Int(5)],
    );
    osc.osc("target/2/visible", &[OscType::Bool(false)]);
    osc.osc("target/1/remove", &[]);
    osc.osc("solver/method", &[word("wgs")]);
    osc.osc("plane/centre", &floats([0.0, 0.0, 0.12]));
    serving.has_foci_of(
        "format = 1\n[[target]]\nkind = \"circle\"\nradius = 0.03\npoints = 5\n[solver]\nmethod = \"wgs\"\n",
    );
    assert_eq!(serving.desk.wish().0.scene.plane.centre.z, 0.12);
    let [x1, y1, x2, y2] = floats([-0.01, 0.0, 0.01, 0.02]);
    let z = OscType::Float(0.1);
    osc.osc("clear", &[]);
    osc.osc("target/add", &[word("line"), x1, y1, z.clone(), x2, y2, z, word("points"), OscType::Int(3)]);
    serving.has_foci_of(
        "format = 1\n[[target]]\nkind = \"line\"\nfrom = [-0.01, 0, 0.1]\nto = [0.01, 0.02, 0.1]\npoints = 3\n[solver]\n\
         method = \"wgs\"\n",
    );
    osc.osc("state", &[]);
    let heard = osc.heard();
    assert_eq!(heard[0].addr, "/sonoglyph/state");
    assert_eq!(heard[0].args[..3], [OscType::Int(1), OscType::Int(3), OscType::Bool(false)]);
    let foci = serving.desk.report().foci();
    for (index, ((at, pressure), answer)) in foci.iter().zip(&heard[1..]).enumerate() {
        assert_eq!(answer.addr, format!("/sonoglyph/focus/{}", index + 1));
        let told: Vec<_> = answer.args.iter().map(|arg| f64::from(arg.clone().float().unwrap())).collect();
        for (told, is) in told.iter().zip([at.x, at.y, at.z, *pressure]) {
            assert!((told - is).abs() <= 1e-6 * is.abs(), "{told} {is}");
        }
    }
    assert_eq!(heard.len(), 4);
}

#[test]
fn a_pad_moves_targets_at_their_height() {
    let file = |[x, y]: [f64; 2]| {
        format!(
            "format = 1\n[[target]]\nat = [{x}, {y}, 0.13]\n[[target]]\nkind = \"line\"\npoints = 3\n\
             from = [{}, {y}, 0.1]\nto = [{}, {y}, 0.12]\n",
            x - 0.01,
            x + 0.01
        )
    };
    let serving = Serving::local(&file([0.0, 0.0]));
    let osc = serving.udp("osc");
    let pad = |number: usize| message(&format!("target/{number}/at"), &floats([0.01, -0.02]));
    osc.bundle(vec![pad(1), pad(2)]);
    serving.has_foci_of(&file([0.01, -0.02]));
}

#[test]
fn files_of_a_table_stay_when_another_key_changes() {
    let serving = Serving::local(TWO);
    let samples = Waveform { file: "a.wav".into(), rate: 8000.0, values: vec![0.0, 1.0] };
    let (shape, file, wave) = (Envelope::File, "a.wav".to_owned(), Wave::new(samples));
    let modulation = Modulation { shape, file, wave, ..Modulation::default() };
    let curve = Curve::new(vec![[20.0, 1e-6], [200.0, 1e-8]], "a.csv".into());
    let skin = Skin { threshold: "a.csv".to_owned(), curve, ..Skin::default() };
    let scene = Scene { modulation: modulation.clone(), skin: Some(skin.clone()), ..scene(TWO) };
    serving.desk.change(&[Edit::Scene(Box::new(scene))]).unwrap();
    serving.udp("osc").osc("modulation/depth", &floats([0.5]));
    let now = || serving.desk.wish().0.scene.modulation.clone();
    eventually("the depth", || now().depth == 0.5);
    serving.udp("osc").osc("skin/depth", &floats([0.5f32.powi(6)]));
    let skins = || serving.desk.wish().0.scene.skin.clone();
    let changed = Skin { depth: Some(0.5f64.powi(6)), ..skin };
    eventually("the layer", || skins().as_ref() == Some(&changed));
    assert_eq!(now(), Modulation { depth: 0.5, ..modulation });
}

#[test]
fn a_wish_of_the_user_replaces_only_the_one_that_it_was_made_from() {
    let desk = Desk::new(Arc::new(scene(TWO)), Box::new(|| {}));
    let (wish, first) = desk.wish();
    let sending = Wish { sends: true, ..wish.clone() };
    let second = desk.put(first, sending.clone()).unwrap();
    assert_eq!((second, desk.generation()), (first + 1, first + 1));
    assert_eq!(desk.put(first, wish.clone()), None);
    assert!(desk.wish().0.sends && desk.generation() == second);
    assert_eq!(desk.put(second, wish), Some(second + 1));
    assert!(!desk.wish().0.sends);
}

#[test]
fn a_bundle_is_one_atomic_change() {
    let serving = Serving::local(TWO);
    let osc = serving.udp("osc");
    let move_to = |x: f32| message("target/1/at", &floats([x, 0.0, 0.1]));
    osc.bundle(vec![move_to(0.01), message("target/3/pressure", &floats([1.0]))]);
    assert!(osc.error().starts_with("target 3: the scene has 2, counted from 1"));
    osc.bundle(vec![move_to(0.01), message("target/1/at", &floats([0.0, 0.0, -0.1]))]);
    let error = osc.error();
    assert!(error.contains("on or behind the array"), "{error}");
    for (address, args, part) in [
        ("target/1/text", vec![OscType::String("A".to_owned())], "only a text has letters"),
        ("target/1/at", floats([0.0]).to_vec(), "other arguments belong to it"),
        ("target/3/at", floats([0.0, 0.0]).to_vec(), "target 3"),
        ("target/0/at", floats([0.0, 0.0, 0.1]).to_vec(), "target 0"),
        ("target/1/pressure", floats([f32::NAN]).to_vec(), "target[1].pressure: must be a number"),
        ("colour", vec![], "there is no such address"),
        ("plane/colour", floats([0.0]).to_vec(), "unknown field `colour`"),
        ("modulation/file", vec![OscType::String("/etc/passwd".to_owned())], "may not name files"),
    ] {
        osc.osc(address, &args);
        let error = osc.error();
        assert!(error.contains(part), "{address}: {error}");
    }
    serving.has_foci_of(TWO);
    let generation = serving.desk.generation();
    osc.bundle(vec![move_to(0.01), move_to(0.02), message("target/2/remove", &[])]);
    serving.has_foci_of("format = 1\n[[target]]\nat = [0.02, 0, 0.1]\n");
    assert_eq!(serving.desk.generation(), generation + 1);
}

#[test]
fn the_newest_of_many_moves_wins() {
    let serving = Serving::local(TWO);
    let osc = serving.udp("osc");
    for step in 0..=200u8 {
        osc.osc("target/1/at", &floats([f32::from(step) / 10_000.0, 0.0, 0.1]));
    }
    serving.has_foci_of(&TWO.replace("-0.02", "0.02"));
}

#[test]
fn ultraino_commands_place_points_with_y_upwards_and_play_at_commit() {
    let serving = Serving::local(TWO);
    let ultraino = serving.udp("ultraino");
    ultraino.send(b"clear");
    ultraino.send(b"create 3\n");
    ultraino.send(b"place 0 0.01 0.1 -0.02");
    ultraino.send(b"Place 1 -0.01 0.12 0.03");
    ultraino.send(b"place 2 9 9 9");
    ultraino.send(b"delete 2");
    ultraino.send(b"update");
    std::thread::sleep(Duration::from_millis(100));
    serving.has_foci_of(TWO);
    assert!(!serving.desk.wish().0.sends);
    ultraino.send(b"commit");
    serving.has_foci_of(
        "format = 1\n[[target]]\nat = [0.01, 0.02, 0.1]\n[[target]]\nat = [-0.01, -0.03, 0.12]\n",
    );
    assert!(serving.desk.wish().0.sends);
    for bad in ["place 0 1", "jump", "create -1", "create 1e9", "\u{fffd}"] {
        ultraino.send(bad.as_bytes());
        let answer = String::from_utf8(ultraino.answer()).unwrap();
        assert!(answer.starts_with("ERR "), "{bad}: {answer}");
    }
    ultraino.send(b"place 7 0 0.1 0\ncommit");
    assert!(String::from_utf8(ultraino.answer()).unwrap().contains("target 8: the scene has 2"));
    assert_eq!(serving.desk.counts.tally().malformed, 5);
}

#[test]
fn json_edits_are_answered_with_state_and_maps() {
    let serving = Serving::local(TWO);
    let mut web = serving.web();
    let done = web.ask(
        r#"{"id": 7, "targets": {"1": {"at": [0.01, 0, 0.11], "pressure": 2}, "2": {"kind": "point"}}, "add": [{"at": [0, 0.02, 0.1]}],
            "remove": [2], "solver": {"method": "gspat"}, "send": true}"#,
    );
    assert_eq!((done["id"].as_u64(), done["done"].as_u64()), (Some(7), Some(2)));
    let text = "format = 1\n[[target]]\nat = [0.01, 0, 0.11]\npressure = 2\n[[target]]\nat = [0, 0.02, 0.1]\n[solver]\nmethod = \"gspat\"\n";
    serving.has_foci_of(text);
    let state = &web.ask(r#"{"state": true}"#)["state"];
    assert_eq!(state["sends"], true);
    assert_eq!(state["targets"][1]["number"], 2);
    assert_eq!(state["targets"][1]["at"], json!([0.0, 0.02, 0.1]));
    let expected = solver::solve(&scene(text)).unwrap();
    assert_eq!(state["foci"][0]["pressure"].as_f64(), Some(expected.pressures[0].norm()));
    assert_eq!(state["counts"]["changes"], 1);

    let head = &web.ask(r#"{"map": {"quantity": "rms", "size": [33, 20]}}"#)["map"];
    assert_eq!((&head["unit"], &head["size"]), (&json!("Pa"), &json!([33, 20])));
    let Message::Binary(bytes) = web.0.read().unwrap() else { panic!("no numbers") };
    let numbers: Vec<f32> =
        bytes.chunks(4).map(|four| f32::from_le_bytes(four.try_into().unwrap())).collect();
    let request = Request::new(&scene(text), expected.drives(), Quantity::Rms, (33, 20));
    let mut stages = Stages::new(Evaluator::Reference);
    let exact = stages.map(&request).unwrap();
    let peak = exact.peak;
    assert!(
        numbers.len() == exact.values.len()
            && (head["peak"].as_f64().unwrap() / f64::from(peak) - 1.0).abs() < 1e-3
    );
    assert!(numbers.iter().zip(&exact.values).all(|(a, b)| (a - b).abs() < 2e-3 * peak));

    let mut watcher = serving.web();
    assert!(watcher.ask(r#"{"watch": true, "id": "w"}"#)["state"]["sends"].as_bool().unwrap());
    web.ask(r#"{"stop": true, "id": 8}"#);
    while watcher.heard()["state"]["sends"] == true {}
    web.ask(r#"{"send": true, "id": 9}"#);
    while watcher.heard()["state"]["sends"] == false {}
    web.send(
        r#"{"scene": {"target": [{"at": [0, 0, 0.15]}], "array": {"rows": 4, "columns": 4}}, "stop": true}"#,
    );
    let seen = loop {
        let seen = watcher.heard();
        if seen["state"]["elements"] == 16 && seen["state"]["solving"] == false {
            break seen;
        }
    };
    assert_eq!((&seen["id"], &seen["state"]["sends"]), (&json!("w"), &json!(false)));
    serving.has_foci_of("format = 1\n[array]\nrows = 4\ncolumns = 4\n[[target]]\nat = [0, 0, 0.15]\n");
    // Nothing changes any more.
    watcher.expect_within(Duration::from_millis(300));
    let late = std::iter::from_fn(|| watcher.0.read().ok()).take(20).count();
    assert!(late < 20, "{late} states of an unchanged scene");
}

#[test]
fn impossible_json_requests_are_answered_and_change_nothing() {
    let serving = Serving::local(TWO);
    let mut web = serving.web();
    for (text, part) in [
        ("[1]", "a message is an object"),
        ("{", "invalid JSON"),
        (r#"{"colour": 1}"#, "colour: there is no such key"),
        (r#"{"targets": {"3": {"at": [0, 0, 0.1]}}}"#, "target 3: the scene has 2"),
        (r#"{"targets": {"1": {"at": [0, 0, 0.1], "radius": 1}}}"#, "can be set alone"),
        (r#"{"targets": {"1": {"kind": "circle", "sides": 4}}}"#, "no such key"),
        (r#"{"targets": {"1": {"at": [0, 0]}}}"#, "targets.1.at: invalid length 2"),
        (r#"{"add": [{"kind": "picture", "file": "/etc/a.png"}]}"#, "may not name files: /etc/a.png"),
        (r#"{"scene": {"target": [{"kind": "picture", "file": "/etc/a.png"}]}}"#, "may not name files"),
        (r#"{"scene": {"modulation": {"file": "/etc/a.wav"}}}"#, "may not name files"),
        (r#"{"scene": {"array": {"elements": "/etc/passwd"}}}"#, "may not name files"),
        (r#"{"scene": {"array": {"wiring": "/etc/passwd"}}}"#, "may not name files"),
        (r#"{"scene": {"array": {"elements": "preset:nothing"}}}"#, "no preset of that name"),
        (r#"{"modulation": {"file": "/etc/a.wav"}}"#, "may not name files"),
        (r#"{"skin": {"threshold": "/etc/passwd"}}"#, "may not name files"),
        (r#"{"scene": {"skin": {"threshold": "/etc/passwd"}}}"#, "may not name files"),
        (r#"{"plane": {"size": [0, 1]}}"#, "plane.size"),
        (r#"{"plane": {"size": [0.1, 0.1, 0.1]}}"#, "plane: "),
        (r#"{"motion": {"path": "spiral"}}"#, "spiral"),
        (r#"{"map": {"size": [0, 10]}}"#, "map.size: 1 to"),
        (r#"{"map": {"size": [100000, 100000]}}"#, "map.size: 1 to"),
        (r#"{"map": {"quantity": "colour"}}"#, "map.quantity: the quantities are rms, "),
    ] {
        let answer = web.ask(text);
        let error = answer["error"].as_str().unwrap_or_else(|| panic!("{text}: {answer}"));
        assert!(error.contains(part), "{text}: {error}");
    }
    web.0.send(Message::binary(vec![1, 2, 3])).unwrap();
    assert_eq!(web.heard()["error"], "messages are JSON, and text");
    assert_eq!(serving.desk.generation(), 1);
    let counts = &web.ask(r#"{"state": true}"#)["state"]["counts"];
    assert_eq!((&counts["malformed"], &counts["refused"]), (&json!(16), &json!(7)));
    // A published array is not a file.
    assert_eq!(web.ask(r#"{"scene": {"array": {"elements": "preset:tinylev-72"}}, "id": 1}"#)["done"], 2);
}

#[test]
fn json_removes_targets_by_the_numbers_before_the_edit_in_any_order() {
    let serving = Serving::local(TWO);
    serving.web().ask(r#"{"id": 1, "remove": [2, 1], "add": [{"at": [0, 0.02, 0.1]}]}"#);
    serving.has_foci_of("format = 1\n[[target]]\nat = [0, 0.02, 0.1]\n");
}

#[test]
fn a_key_alone_changes_and_speed_and_rate_replace_each_other() {
    let text = "format = 1\n[[target]]\nkind = \"text\"\ntext = \"A\"\nat = [0, 0, 0.1]\n";
    let serving = Serving::local(text);
    let mut web = serving.web();
    let mut ask = |text: &str| {
        let answer = web.ask(text);
        assert!(answer["done"].is_number(), "{text}: {answer}");
        serving.desk.wish().0.scene
    };
    let scene = ask(r#"{"targets": {"1": {"angle": 0.5, "visible": false}}, "id": 1}"#);
    assert_eq!((scene.targets[0].angle, scene.targets[0].visible), (0.5, false));
    let circle = r#"{"motion": {"path": "circle", "size": 0.04, "rate": 2.0}, "id": 2}"#;
    let by_rate = ask(circle);
    let by_speed = ask(r#"{"motion": {"speed": 0.5}, "id": 3}"#);
    assert!(by_rate.motion != by_speed.motion);
    assert_eq!(ask(r#"{"motion": {"rate": 2.0}, "id": 4}"#).motion, by_rate.motion);
}

#[test]
fn a_number_sends_and_stops_and_every_packet_is_counted() {
    let serving = Serving::local(TWO);
    let osc = serving.udp("osc");
    for (number, sends) in [(1.0, true), (0.0, false), (-2.5, true)] {
        osc.osc("send", &floats([number]));
        eventually("the wish", || serving.desk.wish().0.sends == sends);
    }
    osc.osc("state", &[]);
    osc.heard();
    // An answer is counted when it is already on its way.
    eventually("the counts", || {
        let tally = serving.desk.counts.tally();
        (tally.packets, tally.answers, tally.unanswered) == (4, 1, 0)
    });
}

#[test]
fn a_report_tells_of_a_solution_that_came_or_went() {
    let solution = Arc::new(solver::solve(&scene(TWO)).unwrap());
    let with = Report { solution: Some(Arc::clone(&solution)), ..Report::default() };
    let (same, without) = (with.clone(), Report::default());
    assert!(!with.tells_more_than(&same) && !without.tells_more_than(&without));
    assert!(with.tells_more_than(&without) && without.tells_more_than(&with));
    let other = Report { solution: Some(Arc::new(Solution::clone(&solution))), ..Report::default() };
    assert!(other.tells_more_than(&with));
    for more in [
        Report { generation: 1, ..with.clone() },
        Report { problem: Some("none".to_owned()), ..with.clone() },
        Report { is_solving: true, ..with.clone() },
    ] {
        assert!(more.tells_more_than(&with) && with.tells_more_than(&more), "{more:?}");
    }
}

#[test]
fn the_loop_rests_until_something_changes() {
    let text = "format = 1\n[[target]]\nat = [0, 0, 0.1]\n";
    let desk = Arc::new(Desk::new(Arc::new(scene(text)), Box::new(|| {})));
    let mut live = Live::new(desk, None);
    live.turn();
    let begun = Instant::now();
    (0..10).for_each(|_| live.turn());
    assert!(begun.elapsed() > Duration::from_millis(100), "{:?}", begun.elapsed());
}

/// A shape's quick drive is replaced by the full one; that of many foci is the full one.
#[test]
fn shapes_and_many_foci_are_solved_in_the_background() {
    for target in ["radius = 0.02", "radius = 0.05\npoints = 130\n[solver]\nmethod = \"naive\""] {
        let text =
            |x: f32| format!("format = 1\n[[target]]\nkind = \"circle\"\nat = [{x}, 0, 0.1]\n{target}\n");
        let serving = Serving::local(&text(0.0));
        let is_solved = |text: &str| {
            let expected = solver::solve(&scene(text)).unwrap();
            eventually(&format!("the full solution of {text}"), || {
                let foci = serving.desk.report().foci();
                let pairs = foci.iter().zip(expected.foci.iter().zip(&expected.pressures));
                foci.len() == expected.foci.len()
                    && pairs.into_iter().all(|((at, a), (focus, b))| {
                        *at == focus.position && (a / b.norm() - 1.0).abs() < 1e-9
                    })
            });
        };
        is_solved(&text(0.0));
        // The first drive of a shape is a quick one, without figures.
        let desk = Arc::new(Desk::new(Arc::new(scene(&text(0.0).replace("0.02", "0.06"))), Box::new(|| {})));
        let mut live = Live::new(Arc::clone(&desk), None);
        eventually("a drive", || {
            live.turn();
            desk.report().solution.is_some()
        });
        assert!(desk.report().solution.as_ref().is_some_and(|first| first.figures.is_none()), "{target}");
        // The drive of many foci replaces that of the scene before; a moved shape goes on from it, to another one.
        if target.contains("points") {
            serving.udp("osc").osc("target/1/at", &floats([0.01, 0.0, 0.1]));
            is_solved(&text(0.01));
        }
    }
}
