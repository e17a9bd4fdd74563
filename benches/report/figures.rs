//! The README's figures: their records in a run, and the table in the README.

use anyhow::Context;
use serde::Deserialize;
use serde_json::{Map, Value};
use sonoglyph::bench::time::{Spread, digits, median};

pub const README: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
/// Delimiters of the table.
const MARKS: [&str; 2] = ["<!-- figures -->\n", "<!-- /figures -->\n"];

/// A number that is similar on all machines.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    pub name: String,
    unit: Unit,
    expected: [f64; 2],
    section: String,
    #[serde(default)]
    record: Map<String, Value>,
    value: String,
    #[serde(default)]
    of: Aggregate,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Unit {
    /// A ratio.
    Times,
    Percent,
    /// Relative to the largest pressure.
    OfPeak,
    Count,
}

/// Choice among the matching records.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Aggregate {
    #[default]
    First,
    Sum,
    Mean,
}

pub fn all() -> anyhow::Result<Vec<Figure>> {
    #[derive(Deserialize)]
    struct File {
        figure: Vec<Figure>,
    }
    Ok(toml::from_str::<File>(include_str!("figures.toml")).context("figures.toml")?.figure)
}

impl Figure {
    /// The figure's value in a run.
    pub fn found(&self, run: &Value) -> Option<Spread> {
        let fits = |record: &&Value| self.record.iter().all(|(key, value)| record[key] == *value);
        let found = run[&self.section]
            .as_array()?
            .iter()
            .filter(fits)
            .filter_map(|record| spread(record.pointer(&self.value)?));
        let found: Vec<_> = found.collect();
        let sum: f64 = found.iter().map(|one| one.median).sum();
        let one = |value: f64| Spread { median: value, quartiles: [value; 2] };
        let first = found.first().copied()?;
        Some(match self.of {
            Aggregate::First => first,
            Aggregate::Sum => one(sum),
            Aggregate::Mean => one(sum / found.len() as f64),
        })
    }

    pub fn text(&self, value: f64) -> String {
        match self.unit {
            Unit::Times => format!("{} x", digits(value)),
            Unit::Percent => format!("{:.1} %", 100.0 * value),
            Unit::OfPeak if value == 0.0 => "0".to_owned(),
            Unit::OfPeak => format!("{value:.1e}"),
            Unit::Count => format!("{value}"),
        }
    }

    pub fn range(&self, [low, high]: [f64; 2]) -> String {
        if low == high { self.text(low) } else { format!("{} … {}", self.text(low), self.text(high)) }
    }

    pub fn expected(&self) -> String {
        self.range(self.expected)
    }

    pub fn is_expected(&self, value: f64) -> bool {
        (self.expected[0]..=self.expected[1]).contains(&value)
    }

    /// The figure's value in a README.
    pub fn stated<'a>(&self, readme: &'a str) -> Option<&'a str> {
        readme.lines().find_map(|line| line.strip_prefix(&format!("| {} | ", self.name))?.split(" | ").next())
    }
}

/// From a number, a Boolean, or a median with its quartiles.
fn spread(value: &Value) -> Option<Spread> {
    let one = |value: f64| Spread { median: value, quartiles: [value; 2] };
    match value {
        Value::Number(number) => number.as_f64().map(one),
        Value::Bool(truth) => Some(one(f64::from(*truth))),
        Value::Object(spread) => {
            let quartile = |i: usize| spread.get("quartiles")?[i].as_f64();
            Some(Spread { median: spread.get("median")?.as_f64()?, quartiles: [quartile(0)?, quartile(1)?] })
        }
        Value::Null | Value::String(_) | Value::Array(_) => None,
    }
}

/// The README with the medians of runs in its table.
pub fn inserted(readme: &str, runs: &[Value]) -> anyhow::Result<String> {
    let [begin, end] = MARKS;
    let missing = || format!("{README}: `{}` and `{}` must delimit the table", begin.trim(), end.trim());
    let (head, rest) = readme.split_once(begin).with_context(missing)?;
    let (_, tail) = rest.split_once(end).with_context(missing)?;
    Ok(format!("{head}{begin}{}{end}{tail}", table(runs)?))
}

fn table(runs: &[Value]) -> anyhow::Result<String> {
    let mut text = format!("{}\n\n| figure | value | expected within |\n|---|---|---|\n", origin(runs));
    for figure in all()? {
        let found: Vec<_> =
            runs.iter().filter_map(|run| figure.found(run)).map(|found| found.median).collect();
        anyhow::ensure!(!found.is_empty(), "no run has measured `{}`: {}", figure.section, figure.name);
        text += &format!("| {} | {} | {} |\n", figure.name, figure.text(median(&found)), figure.expected());
    }
    Ok(text)
}

/// Build, dates and machines of the runs.
fn origin(runs: &[Value]) -> String {
    let of = |key: &str| {
        let mut all: Vec<_> = runs.iter().filter_map(|run| run.pointer(key)).map(shown).collect();
        all.sort();
        all.dedup();
        all.join("; ")
    };
    let build =
        if runs.iter().all(|run| run["optimised"] == true) { "" } else { ", partly of development builds" };
    let number = match runs.len() {
        1 => "One run".to_owned(),
        more => format!("Medians of {more} runs"),
    };
    format!(
        "{number}{build}: sonoglyph {}; {}.\n{}, {} threads, {}.\nGPU: {}.",
        of("/version"),
        of("/date"),
        of("/machine/processor"),
        of("/machine/threads"),
        of("/machine/instructions"),
        of("/machine/adapters"),
    )
}

/// A value as text.
fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(values) if values.is_empty() => "none".to_owned(),
        Value::Array(values) => values.iter().map(shown).collect::<Vec<_>>().join(", "),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::Object(_) => value.to_string(),
    }
}
