//! `sonoglyph devices`: the field evaluators of this machine, and the automatic choice.

use crate::field::gpu::Kind;
use crate::field::gpu::adapter;
use crate::simd::Isa;
use crate::studio::output::say;

pub fn run() -> anyhow::Result<()> {
    let adapters = adapter::adapters();
    say!("GPU adapters, best first:")?;
    if adapters.is_empty() {
        say!("  none: no graphics driver offers one")?;
    }
    for info in &adapters {
        say!("  {info}")?;
    }
    let sets: Vec<_> = Isa::available().iter().map(|isa| isa.name()).collect();
    say!("CPU evaluator:")?;
    say!("  {} threads, {} (has {})", rayon::current_num_threads(), Isa::best().name(), sets.join(", "))?;
    say!("f64 reference:")?;
    say!("  always available")?;
    say!("`--backend auto` would use:")?;
    match adapters.first() {
        Some(info) if info.kind != Kind::Software => {
            say!("  {} for maps, since it is a hardware GPU", info.name)?;
        }
        Some(info) => {
            say!(
                "  the CPU evaluator for maps, since {} is software on the same CPU, and slower",
                info.name
            )?;
        }
        None => say!("  the CPU evaluator for maps, since there is no GPU adapter")?,
    }
    say!("  the f64 reference for points")
}
