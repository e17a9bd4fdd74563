//! What a measurement depends on: the machine, and the program.

use serde_json::{Value, json};

use crate::field::gpu::adapter;
use crate::simd::Isa;

/// Of this run, under the keys that a report begins with.
pub fn json() -> Value {
    json!({
        "machine": {
            "processor": processor(),
            "threads": rayon::current_num_threads(),
            "instructions": Isa::best().name(),
            "architecture": std::env::consts::ARCH,
            "system": std::env::consts::OS,
            "adapters": adapter::adapters().iter().map(ToString::to_string).collect::<Vec<_>>(),
        },
        "version": env!("CARGO_PKG_VERSION"),
        "compiler": option_env!("SONOGLYPH_RUSTC"),
        // Times of a build for debugging mean nothing.
        "optimised": !cfg!(debug_assertions),
        "command": std::env::args().skip(1).fold("sonoglyph".to_owned(), |command, word| command + " " + &word),
    })
}

/// As the system calls it, where it does.
fn processor() -> Option<String> {
    let known = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let model = known.lines().find_map(|line| line.strip_prefix("model name"))?;
    Some(model.trim_start_matches([' ', '\t', ':']).to_owned())
}
