//! What a test needs of the machine, and what may not be missing there: `SONOGLYPH_REQUIRE=gpu,display,rtl,examples,video`.

use std::fmt::Display;

/// What was looked for. Where it is missing the test fails if it is required; else that it is left out is said aloud.
pub fn found<T>(what: &str, looked_for: Result<T, impl Display>) -> Option<T> {
    let required = std::env::var("SONOGLYPH_REQUIRE").unwrap_or_default();
    let left_out = |missing: &dyn Display| {
        assert!(!required.split(',').any(|own| own == what), "{what} is required: {missing}");
        eprintln!("NOT TESTED, for want of {what}: {missing}");
    };
    looked_for.inspect_err(|missing| left_out(missing)).ok()
}
