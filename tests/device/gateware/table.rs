//! The packet tables in Verilog and in Rust hold the same numbers.

use std::collections::BTreeMap;
use std::path::Path;

use sonoglyph::device::native::packet::{Kind, Outcome, REPLY};
use strum::VariantArray;

/// The numbers defined in `packets.vh` under a prefix, by the rest of their names.
fn defined(prefix: &str) -> BTreeMap<String, usize> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("gateware/rtl/packets.vh");
    let text = std::fs::read_to_string(path).unwrap();
    let define = format!("`define {prefix}_");
    let lines = text.lines().filter_map(|line| line.strip_prefix(&define));
    lines
        .map(|line| {
            let (name, number) = line.split_once(' ').unwrap();
            let (radix, digits) = match number.split_once('\'') {
                Some((_, digits)) => (if digits.starts_with('h') { 16 } else { 10 }, &digits[1..]),
                None => (10, number),
            };
            (name.to_owned(), usize::from_str_radix(digits, radix).unwrap())
        })
        .collect()
}

fn table<T: Copy + Into<&'static str> + VariantArray>(number: fn(T) -> usize) -> BTreeMap<String, usize> {
    T::VARIANTS.iter().map(|&one| (one.into().to_owned(), number(one))).collect()
}

#[test]
fn packets_have_the_same_codes_lengths_and_results_in_verilog_and_rust() {
    let mut codes = table(|kind: Kind| usize::from(kind.code()));
    codes.insert("ANSWER".to_owned(), usize::from(REPLY));
    assert_eq!(defined("TYPE"), codes);
    assert_eq!(defined("PAYLOAD"), table(Kind::payload));
    assert_eq!(defined("RESULT"), table(|outcome: Outcome| usize::from(outcome.code())));
}
