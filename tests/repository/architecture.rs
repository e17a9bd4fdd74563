//! Rules of ARCHITECTURE.md that the compiler does not enforce: layers, first lines and names.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The layers, the uppermost first, with their external crates. A module uses only itself and layers above.
const LAYERS: &[(&str, &[&str])] = &[
    ("echo", &[]),
    ("shelf", &[]),
    ("source", &["rustix", "tempfile"]),
    ("memory", &[]),
    ("gauge", &["web_time"]),
    ("mesh", &["glam", "rayon", "thiserror"]),
    ("scene", &["serde", "toml", "toml_edit", "glam", "thiserror"]),
    ("table", &["csv", "flate2", "npyz", "roxmltree", "serde_json", "thiserror"]),
    ("rounding", &[]),
    ("simd", &[]),
    ("special", &["libm"]),
    ("scatter", &["glam", "num_complex", "rayon", "thiserror"]),
    ("acoustics", &["glam", "libm", "num_complex", "rayon", "sonoglyph_fourier"]),
    ("drive", &["glam", "num_complex"]),
    ("force", &["glam", "num_complex", "rayon"]),
    ("surface", &["num_complex", "rayon", "sonoglyph_fourier"]),
    ("field", &["bytemuck", "glam", "num_complex", "rayon", "serde", "sonoglyph_fourier", "thiserror"]),
    ("solver", &["glam", "num_complex", "rayon", "serde", "thiserror", "web_time"]),
    ("measure", &["glam", "num_complex", "rayon", "strum", "thiserror"]),
    ("field::gpu", &["bytemuck", "glam", "naga", "num_complex", "pollster", "thiserror", "wgpu"]),
    (
        "picture",
        &[
            "base64",
            "color_quant",
            "colorous",
            "gif",
            "glam",
            "image",
            "miniz_oxide",
            "npyz",
            "num_complex",
            "pdf_writer",
            "png",
            "rayon",
            "subsetter",
            "thiserror",
            "tiny_skia",
            "ttf_parser",
        ],
    ),
    (
        "import",
        &[
            "encoding_rs",
            "flate2",
            "glam",
            "i_overlay",
            "image",
            "kurbo",
            "roxmltree",
            "thiserror",
            "tiny_skia",
            "usvg",
        ],
    ),
    (
        "device",
        &[
            "cobs",
            "crc",
            "fastrand",
            "js_sys",
            "pollster",
            "rustix",
            "serialport",
            "signal_hook",
            "thread_priority",
            "thiserror",
            "wasm_bindgen",
            "wasm_bindgen_futures",
            "web_time",
        ],
    ),
    (
        "studio",
        &[
            "anyhow",
            "base64",
            "clap",
            "glam",
            "hound",
            "miniz_oxide",
            "num_complex",
            "rayon",
            "rustix",
            "serde",
            "serde_json",
            "signal_hook",
            "sonoglyph_fourier",
            "tempfile",
            "thiserror",
            "web_time",
        ],
    ),
    ("web", &["console_error_panic_hook", "js_sys", "wasm_bindgen", "wasm_bindgen_futures", "web_time"]),
    (
        "control",
        &[
            "anyhow",
            "getrandom",
            "glam",
            "rosc",
            "serde",
            "serde_json",
            "thiserror",
            "tungstenite",
            "web_time",
        ],
    ),
    ("ui", &["egui", "egui_plot", "glam", "serde"]),
    (
        "app",
        &[
            "anyhow",
            "base64",
            "console_error_panic_hook",
            "ctrlc",
            "eframe",
            "egui",
            "futures_channel",
            "glam",
            "js_sys",
            "pollster",
            "postcard",
            "rfd",
            "serde",
            "serde_json",
            "signal_hook",
            "tempfile",
            "toml",
            "wasm_bindgen",
            "wasm_bindgen_futures",
            "web_sys",
            "web_time",
            "wgpu",
        ],
    ),
    ("bench", &["anyhow", "clap", "comfy_table", "cpu_time", "glam", "num_complex", "rayon", "serde_json"]),
    (
        "cli",
        &[
            "anyhow",
            "clap",
            "clap_complete",
            "clap_mangen",
            "comfy_table",
            "glam",
            "indicatif",
            "num_complex",
            "rayon",
            "serde_json",
            "signal_hook",
            "strsim",
            "tempfile",
        ],
    ),
    ("main", &["anyhow", "libc", "sonoglyph", "windows_sys"]),
];
/// Modules that must not name each other, whatever their order: command line and window meet only in `main`.
const APART: &[(&str, &[&str])] = &[("bench", &["ui", "app"]), ("cli", &["ui", "app"])];
/// Crates allowed in every layer.
const COMMON: &[&str] = &["std", "crate", "self", "strum"];
/// Each test program links the whole library.
const MOST_TEST_PROGRAMS: usize = 10;
const BAD_NAMES: &[&str] = &["utils", "util", "common", "helpers", "helper", "manager", "misc", "wrapper"];

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Of both packages, whose layers are one sequence.
fn sources() -> Vec<PathBuf> {
    ["engine/src", "src"].iter().flat_map(|folder| rust_files(&root().join(folder))).collect()
}

/// `engine/src/field/gpu/mod.rs` is `field::gpu`.
fn module_of(path: &Path) -> String {
    let path = path.strip_prefix(root()).unwrap().with_extension("");
    let mut parts: Vec<_> =
        path.iter().skip_while(|part| *part != "src").skip(1).map(|part| part.to_str().unwrap()).collect();
    if parts.last() == Some(&"mod") {
        parts.pop();
    }
    parts.join("::")
}

/// The innermost layer of a module.
fn layer_of(module: &str) -> Option<usize> {
    let inside = |layer: &str| module == layer || module.starts_with(&format!("{layer}::"));
    (0..LAYERS.len()).filter(|&i| inside(LAYERS[i].0)).max_by_key(|&i| LAYERS[i].0.len())
}

/// Code without comments and strings, line by line.
fn code_lines(text: &str) -> impl Iterator<Item = (usize, String)> {
    let strip = |line: &str| {
        let mut code = String::new();
        let mut in_string = false;
        for part in line.split("//").next().unwrap_or_default().split('"') {
            if !in_string {
                code.push_str(part);
            }
            in_string = !in_string;
        }
        code
    };
    text.lines().map(strip).collect::<Vec<_>>().into_iter().enumerate().map(|(i, line)| (i + 1, line))
}

/// First segments of every path in a line of code, and the second after `crate`.
fn paths(line: &str) -> Vec<String> {
    let mut paths = Vec::new();
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut rest = line;
    while let Some(at) = rest.find("::") {
        let before = &rest[..at];
        let start =
            before.rfind(|c| !is_word(c)).map_or(0, |i| i + before[i..].chars().next().unwrap().len_utf8());
        let first = &before[start..];
        let continues = before[..start].ends_with("::");
        let after = &rest[at + 2..];
        let second: String = after.chars().take_while(|&c| is_word(c)).collect();
        if !continues && first.starts_with(char::is_lowercase) {
            let through_crate = first == "crate";
            paths.push(if through_crate { format!("crate::{second}") } else { first.to_owned() });
        }
        // Skip the rest of this path.
        rest = after.trim_start_matches(|c| is_word(c) || c == ':');
    }
    paths
}

/// Whether a module must not name another, even if the table allows it.
fn are_apart(own: &str, used: &str) -> bool {
    APART.iter().any(|(module, others)| own == *module && others.contains(&used))
}

/// Violations of a file's layer, one line each.
fn violations(path: &Path, text: &str) -> Vec<String> {
    let outside = outside();
    let module = module_of(path);
    let shown = path.strip_prefix(root()).unwrap().display().to_string();
    let Some(layer) = layer_of(&module) else { return vec![format!("{shown}: is in no layer")] };
    let mut found = Vec::new();
    let (_, crates) = LAYERS[layer];
    let modules: Vec<_> = LAYERS.iter().map(|(name, _)| name.split("::").next().unwrap()).collect();
    let own = module.split("::").next().unwrap();
    for (number, line) in code_lines(text) {
        if line.contains("use crate::{") || (line.contains("super::") && line.trim() != "use super::*;") {
            found.push(format!("{shown}:{number}: write whole paths from `crate`"));
        }
        for name in paths(&line) {
            if let Some(used) = name.strip_prefix("crate::") {
                let upwards =
                    LAYERS.iter().position(|(layer, _)| *layer == used).is_some_and(|used| used <= layer);
                if modules.contains(&used) && used != own && !upwards {
                    found.push(format!("{shown}:{number}: `{own}` uses `{used}`, which is not above it"));
                }
                if are_apart(own, used) {
                    found.push(format!(
                        "{shown}:{number}: `{own}` uses `{used}`, and is to know nothing of it"
                    ));
                }
            }
        }
        let declared = line
            .trim_start()
            .trim_start_matches("pub ")
            .strip_prefix("use ")
            .and_then(|used| used.split("::").next());
        let named = declared.map(str::trim_end).into_iter().map(str::to_owned).chain(paths(&line));
        for name in named {
            if outside.contains(&name) && !crates.contains(&name.as_str()) && !COMMON.contains(&name.as_str())
            {
                found.push(format!(
                    "{shown}:{number}: `{}` names `{name}`, which it may not",
                    LAYERS[layer].0
                ));
            }
        }
    }
    found.dedup();
    found
}

/// The crates in both packages' Cargo.toml, as written in code.
fn outside() -> BTreeSet<String> {
    let crates_of = |path: &str| -> Vec<String> {
        let manifest: toml::Table = toml::from_str(&fs::read_to_string(root().join(path)).unwrap()).unwrap();
        let systems = manifest["target"].as_table().unwrap().values();
        [&manifest["dependencies"]]
            .into_iter()
            .chain(systems.map(|system| &system["dependencies"]))
            .flat_map(|crates| crates.as_table().unwrap().keys())
            .map(|name| name.replace('-', "_"))
            .collect()
    };
    let crates = ["engine/Cargo.toml", "Cargo.toml"].iter().flat_map(|path| crates_of(path));
    crates.chain(["sonoglyph".to_owned()]).collect()
}

#[test]
fn every_module_uses_only_layers_above_it() {
    let mut found = Vec::new();
    for path in sources() {
        if !path.ends_with("src/lib.rs") {
            found.extend(violations(&path, &fs::read_to_string(&path).unwrap()));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_rule_finds_violations() {
    let in_file = |path: &str, text: &str| violations(&root().join("src").join(path), text);
    for (path, text) in [
        ("field/cpu.rs", "use crate::solver::Solution;"),
        ("scene/mod.rs", "let x = crate::cli::run();"),
        ("studio/map.rs", "use crate::cli::run;"),
        ("studio/map.rs", "use crate::ui::view::Lens;"),
        ("app/mod.rs", "use crate::cli::run;"),
        ("ui/mod.rs", "crate::cli::run()"),
        ("cli/mod.rs", "use crate::ui::view::Lens;"),
        ("cli/mod.rs", "crate::app::run(None)"),
        ("solver/mod.rs", "#[derive(clap::ValueEnum)]"),
        ("solver/mod.rs", "use wgpu::Device;"),
        ("field/cpu.rs", "fn f(d: &wgpu::Device) {}"),
        ("picture/mod.rs", "pub use clap::Parser;"),
        ("solver/mod.rs", "use crate::{field, scene};"),
        ("utilities.rs", ""),
    ] {
        assert_eq!(in_file(path, text).len(), 1, "{path}: {text}");
    }
    for (path, text) in [
        ("solver/mod.rs", "use crate::acoustics::Aperture;\nuse rayon::prelude::*;"),
        ("solver/mod.rs", "// like wgpu::Device and crate::field::Samples"),
        ("field/gpu/mod.rs", "let d: wgpu::Device = crate::field::gpu::open();"),
        ("cli/mod.rs", "let f = crate::field::cpu::pressure;"),
        ("cli/mod.rs", "use crate::studio::map;"),
        ("app/mod.rs", "use crate::studio::map;\nuse crate::ui::Editor;"),
    ] {
        assert_eq!(in_file(path, text), Vec::<String>::new(), "{path}: {text}");
    }
}

/// The modules below `crate` named by a text, with braces expanded: `a::b::{c, d}` gives `a::b::c` and `a::b::d`.
fn named_modules(text: &str) -> BTreeSet<String> {
    let is_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let code: String = code_lines(text).map(|(_, line)| line + "\n").collect();
    let mut named = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        let path: String = rest.chars().take_while(|&c| is_path(c)).collect();
        match rest[path.len()..].strip_prefix('{') {
            Some(inner) => {
                let inner = inner.split('}').next().unwrap();
                named.extend(inner.split(',').map(|name| format!("{path}{}", name.trim())));
            }
            None => {
                named.insert(path);
            }
        }
    }
    named
}

/// Paths below `crate` that a file passes on by `pub use`, with the paths that they stand for.
fn passed_on(files: &BTreeMap<String, String>) -> BTreeMap<String, String> {
    let mut passed_on = BTreeMap::new();
    for (module, text) in files {
        let code: String = code_lines(text).map(|(_, line)| format!(" {}", line.trim())).collect();
        for (before, tree) in code.split(';').filter_map(|statement| statement.rsplit_once(" use ")) {
            let within = before.rsplit_once("pub").map(|(_, within)| within);
            if !within
                .is_some_and(|within| within.is_empty() || within.starts_with('(') && within.ends_with(')'))
            {
                continue;
            }
            for path in expanded(tree) {
                let name = format!("{module}::{}", path.rsplit("::").next().unwrap());
                let path =
                    path.strip_prefix("crate::").map_or_else(|| format!("{module}::{path}"), str::to_owned);
                passed_on.insert(name, path);
            }
        }
    }
    passed_on
}

/// The paths of `a::{b, c::{d, e}}`.
fn expanded(tree: &str) -> Vec<String> {
    let Some((stem, inner)) = tree.trim().split_once('{') else { return vec![tree.trim().to_owned()] };
    let inner = inner.trim_end().trim_end_matches('}');
    let mut depth = 0;
    let parts = inner.split(|c: char| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    });
    let parts: Vec<_> = parts.filter(|part| !part.trim().is_empty()).collect();
    parts.into_iter().flat_map(expanded).map(|part| format!("{stem}{part}")).collect()
}

/// From each file to the files that define what it names; passing a name on is not naming it.
fn arrows(files: &BTreeMap<String, String>) -> BTreeMap<&str, BTreeSet<&str>> {
    let passed_on = passed_on(files);
    let within = |path: &str, module: &str| {
        path.strip_prefix(module).is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
    };
    let origin = |mut path: String| {
        // A function may have its file's name.
        let known = |path: &str| {
            let known = passed_on.iter().filter(|(name, origin)| within(path, name) && !within(origin, name));
            known.max_by_key(|(name, _)| name.len())
        };
        while let Some((name, origin)) = known(&path) {
            path = format!("{origin}{}", &path[name.len()..]);
        }
        path
    };
    let file_of = |path: &str| {
        let holds = |module: &&String| within(path, module);
        files.keys().filter(holds).max_by_key(|module| module.len()).map(String::as_str)
    };
    let targets = |module: &str, text: &str| {
        let text = without_tests(text);
        let mut named = named_modules(text);
        // A folder's own code names its files by their names alone.
        let parts = |line: &str| {
            line.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':')
                .map(str::to_owned)
                .collect::<Vec<_>>()
        };
        let lines = code_lines(text).filter(|(_, line)| !(line.starts_with("pub") && line.contains(" use ")));
        for path in lines.flat_map(|(_, line)| parts(&line)).filter(|path| path.contains("::")) {
            let path = format!("{module}::{path}");
            named.extend(file_of(&path).filter(|file| *file != module).map(|_| path.clone()));
        }
        named.into_iter().filter_map(|path| file_of(&origin(path))).filter(|file| *file != module).collect()
    };
    files.iter().map(|(module, text)| (module.as_str(), targets(module, text))).collect()
}

/// The files from which arrows lead back to them.
fn circles(files: &BTreeMap<String, String>) -> BTreeSet<&str> {
    let arrows = arrows(files);
    let comes_back = |start: &&str| {
        let (mut met, mut next) = (BTreeSet::new(), vec![*start]);
        while let Some(file) = next.pop() {
            next.extend(arrows[file].iter().filter(|to| met.insert(**to)));
        }
        met.contains(start)
    };
    arrows.keys().copied().filter(comes_back).collect()
}

#[test]
fn no_files_refer_to_each_other_in_a_circle() {
    let files: BTreeMap<_, _> = sources()
        .into_iter()
        .filter(|path| path.parent().is_some_and(|folder| !folder.ends_with("src")))
        .map(|path| (module_of(&path), fs::read_to_string(&path).unwrap()))
        .collect();
    assert_eq!(circles(&files), BTreeSet::new());
    assert!(arrows(&files).values().map(BTreeSet::len).sum::<usize>() > 100);

    let files = [
        ("a::x", "use crate::a::{y, z};"),
        ("a::y", "crate::b::f()"),
        ("a::z", ""),
        ("b", "use crate::a::x::N;"),
    ];
    let files = files.map(|(module, text)| (module.to_owned(), text.to_owned())).into();
    assert_eq!(circles(&files), ["a::x", "a::y", "b"].into());
}

/// Names forbidden in all sources, with the reason.
const NOWHERE: &[(&str, &str)] = &[
    ("SystemTime", "the system clock may jump: use `Instant`"),
    ("UNIX_EPOCH", "the system clock may jump: use `Instant`"),
    ("println!", "it panics on closed pipes and full disks: use `say!`, `note`, `warn` or `mention`"),
    ("print!", "it panics on closed pipes and full disks: use `output::print`"),
    ("fs::write(", "it may leave a partial file: use `output`"),
    ("File::create(", "it may leave a partial file: use `output`"),
];

/// The code of a file without the unit tests at its end.
fn without_tests(text: &str) -> &str {
    text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default()
}

#[test]
fn no_source_uses_forbidden_names() {
    let mut found = Vec::new();
    for path in sources() {
        let text = fs::read_to_string(&path).unwrap();
        for (number, line) in code_lines(without_tests(&text)) {
            let named = NOWHERE.iter().filter(|(name, _)| {
                line.match_indices(name).any(|(at, _)| !line[..at].ends_with(char::is_alphanumeric))
            });
            found.extend(named.map(|(name, why)| format!("{}:{number}: {name}: {why}", path.display())));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    let line = "    println!(now = SystemTime::now());";
    assert!(NOWHERE.iter().filter(|(name, _)| line.contains(name)).count() >= 2, "the rule finds violations");
}

#[test]
fn every_file_opens_with_its_purpose_and_has_a_name() {
    for folder in ["engine", "src", "python", "tests", "benches", "fuzz/fuzz_targets"] {
        for path in rust_files(&root().join(folder)) {
            let text = fs::read_to_string(&path).unwrap();
            assert!(text.starts_with("//! "), "{}: must open with a //! line", path.display());
            let name = path.file_stem().unwrap().to_str().unwrap();
            assert!(!BAD_NAMES.contains(&name), "{}: a name without meaning", path.display());
        }
    }
}

#[test]
fn tests_are_modules_of_few_binaries() {
    let is_program = |path: &PathBuf| path.is_file() || path.join("main.rs").exists();
    let entries =
        ["tests", "engine/tests"].iter().flat_map(|folder| fs::read_dir(root().join(folder)).unwrap());
    let programs: Vec<_> = entries.map(|entry| entry.unwrap().path()).filter(is_program).collect();
    assert!((1..=MOST_TEST_PROGRAMS).contains(&programs.len()), "{programs:?}");
}
