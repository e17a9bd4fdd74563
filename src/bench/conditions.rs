//! Conditions of a measurement: the machine and the build, as JSON for a report.

use serde_json::{Value, json};

use crate::field::gpu::adapter;
use crate::simd::Isa;

/// The conditions of this run.
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
        // Times of development builds are meaningless.
        "optimised": !cfg!(debug_assertions),
        "command": std::env::args().skip(1).fold("sonoglyph".to_owned(), |command, word| command + " " + &word),
    })
}

/// The processor's name in Linux.
fn processor() -> Option<String> {
    let known = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let model = known.lines().find_map(|line| line.strip_prefix("model name"))?;
    Some(model.trim_start_matches([' ', '\t', ':']).to_owned())
}
