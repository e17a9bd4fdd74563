//! Optional equipment of the machine, required by `SONOGLYPH_REQUIRE=gpu,display,rtl,examples,video`.

use std::fmt::Display;

/// The equipment, if found. Otherwise the test fails if it is required, or prints what it leaves out.
pub fn found<T>(what: &str, looked_for: Result<T, impl Display>) -> Option<T> {
    let required = std::env::var("SONOGLYPH_REQUIRE").unwrap_or_default();
    let left_out = |missing: &dyn Display| {
        assert!(!required.split(',').any(|own| own == what), "{what} is required: {missing}");
        eprintln!("NOT TESTED without {what}: {missing}");
    };
    looked_for.inspect_err(|missing| left_out(missing)).ok()
}
