//! The figures that the README states, with the spread that it states for them, and what a run makes of them.

use serde_json::{Value, json};

use crate::bench::time::{Spread, digits};

/// Where the stated values were measured.
pub const MACHINE: &str = "two cores of an Intel Xeon or an AMD EPYC with AVX-512, without a GPU";

/// A number that is to come out alike on other machines: a ratio within a run, an error or a count.
#[derive(Debug)]
pub struct Figure {
    pub name: &'static str,
    unit: Unit,
    /// The median of several runs on [`MACHINE`].
    value: f64,
    /// All of them lay well between these, which leave room for other machines.
    spread: [f64; 2],
    /// Where it stands in the JSON of a run: a number, or one with quartiles.
    find: fn(&Value) -> Option<Value>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    /// How many times as much, or as fast.
    Times,
    Percent,
    /// Of the largest pressure.
    OfPeak,
    Count,
}

/// What a run found for a figure.
#[derive(Clone, Debug)]
pub struct Measured {
    pub figure: &'static Figure,
    pub found: Spread,
}

const FIGURES: [Figure; 16] = [
    Figure {
        name: "a map of 1024 x 1024 pixels within 1e-3 of its peak, after a new drive: faster than evaluating every pixel",
        unit: Unit::Times,
        value: 59.0,
        spread: [20.0, 150.0],
        find: |report| map(report, 1e-3, "new_drive_ratio"),
    },
    Figure {
        name: "the same after a new plane, which needs a new transfer",
        unit: Unit::Times,
        value: 46.8,
        spread: [20.0, 120.0],
        find: |report| map(report, 1e-3, "new_plane_ratio"),
    },
    Figure {
        name: "error of that map against f64",
        unit: Unit::OfPeak,
        value: 2.5e-5,
        spread: [0.0, 1e-3],
        find: |report| map(report, 1e-3, "error"),
    },
    Figure {
        name: "error of every pixel evaluated in f32, against f64",
        unit: Unit::OfPeak,
        value: 2.6e-7,
        spread: [0.0, 2e-5],
        find: |report| map(report, 0.0, "error"),
    },
    Figure {
        name: "a depression of water, 512 x 512 pixels: time over that of the pressure's picture",
        unit: Unit::Times,
        value: 3.23,
        spread: [1.5, 6.0],
        find: |report| dent(report, 1),
    },
    Figure {
        name: "the same for the mean over a motion of 64 frames",
        unit: Unit::Times,
        value: 45.4,
        spread: [10.0, 100.0],
        find: |report| dent(report, 64),
    },
    Figure {
        name: "`best` for 32 random foci: faster than 200 iterations of weighted Gerchberg-Saxton",
        unit: Unit::Times,
        value: 3.13,
        spread: [2.0, 6.0],
        find: |report| best(report, "time_ratio"),
    },
    Figure {
        name: "and its weakest focus: as strong as that of the same",
        unit: Unit::Times,
        value: 1.0,
        spread: [0.97, 1.03],
        find: |report| best(report, "strength_ratio"),
    },
    Figure {
        name: "and the part of what no drive can exceed that it surely reaches, mean over 20 sets",
        unit: Unit::Percent,
        value: 0.917,
        spread: [0.9, 0.93],
        find: |report| best(report, "certified_mean"),
    },
    Figure {
        name: "the next frame of a motion of 8 foci: faster than a search",
        unit: Unit::Times,
        value: 1.89,
        spread: [1.3, 3.0],
        find: |report| {
            let found =
                record(report, "solve", &json!({ "workload": "moving", "method": "best, followed" }))?;
            Some(found["time_ratio"].clone())
        },
    },
    Figure {
        name: "solutions of 14 hard sets of foci that are finite and within full drive",
        unit: Unit::Percent,
        value: 1.0,
        spread: [1.0, 1.0],
        find: |report| {
            let all: Vec<_> =
                report["stability"].as_array()?.iter().filter(|record| record["foci"] != 1000).collect();
            let sound = all.iter().filter(|record| record["sound"] == true).count();
            Some(json!(sound as f64 / all.len() as f64))
        },
    },
    Figure {
        name: "the drive of a drawing: least pressure along its strokes over their mean, in the worst drawing",
        unit: Unit::Percent,
        value: 0.906,
        spread: [0.85, 0.95],
        find: |report| drawn(report, "evenness", "least"),
    },
    Figure {
        name: "and the loudest place beside it over that mean, mean over the drawings",
        unit: Unit::Percent,
        value: 0.464,
        spread: [0.4, 0.5],
        find: |report| drawn(report, "side_lobe", "mean"),
    },
    Figure {
        name: "a frame in which one of 8 foci is dragged, in a window of 1280 x 800: faster than with every pixel evaluated",
        unit: Unit::Times,
        value: 18.4,
        spread: [10.0, 40.0],
        find: |report| {
            let dragged = json!({ "what": "drag one of 8 foci", "width": 1280.0 });
            Some(record(report, "window", &dragged)?["time_ratio"].clone())
        },
    },
    Figure {
        name: "frames of the window in a second in which nothing happens",
        unit: Unit::Count,
        value: 0.0,
        spread: [0.0, 0.0],
        find: |report| {
            Some(record(report, "window", &json!({ "what": "nothing happens" }))?["frames"].clone())
        },
    },
    Figure {
        name: "frames that links at full speed brought to boards otherwise than they were sent",
        unit: Unit::Count,
        value: 0.0,
        spread: [0.0, 0.0],
        find: |report| {
            let torn = report["link"].as_array()?.iter().filter_map(|record| record["torn"].as_u64());
            Some(json!(torn.sum::<u64>()))
        },
    },
];

fn map(report: &Value, tolerance: f64, key: &str) -> Option<Value> {
    let wanted = json!({
        "evaluator": "cpu", "plane": "parallel", "elements": 256, "width": 1024, "tolerance": tolerance,
    });
    Some(record(report, "field", &wanted)?[key].clone())
}

fn dent(report: &Value, frames: usize) -> Option<Value> {
    let wanted = json!({
        "evaluator": "cpu", "picture": "dent", "frames": frames, "width": 512, "tolerance": 1e-3,
    });
    Some(record(report, "dent", &wanted)?["ratio_to_field"].clone())
}

fn best(report: &Value, key: &str) -> Option<Value> {
    let wanted = json!({ "workload": "plane", "foci": 32, "method": "best" });
    Some(record(report, "solve", &wanted)?[key].clone())
}

/// At the end of the search.
fn drawn(report: &Value, key: &str, of_all: &str) -> Option<Value> {
    let wanted = json!({ "drawing": "all", "drive": "end" });
    Some(record(report, "shapes", &wanted)?[key][of_all].clone())
}

/// The first record of a section that has all these values.
fn record<'a>(report: &'a Value, section: &str, wanted: &Value) -> Option<&'a Value> {
    let wanted = wanted.as_object()?;
    report[section].as_array()?.iter().find(|record| wanted.iter().all(|(key, value)| record[key] == *value))
}

/// The figures that a run has records for.
pub fn measured(report: &Value) -> Vec<Measured> {
    let spread = |value: Value| match value {
        Value::Number(number) => Some(Spread::of(vec![number.as_f64()?])),
        value => {
            let quartile = |i: usize| value["quartiles"][i].as_f64();
            Some(Spread { median: value["median"].as_f64()?, quartiles: [quartile(0)?, quartile(1)?] })
        }
    };
    let measured = |figure| Some(Measured { figure, found: spread((figure.find)(report)?)? });
    FIGURES.iter().filter_map(measured).collect()
}

impl Figure {
    fn text(&self, value: f64) -> String {
        match self.unit {
            Unit::Times => format!("{} x", digits(value)),
            Unit::Percent => format!("{:.1} %", 100.0 * value),
            Unit::OfPeak if value == 0.0 => "0".to_owned(),
            Unit::OfPeak => format!("{value:.1e}"),
            Unit::Count => format!("{value}"),
        }
    }

    fn range(&self, [low, high]: [f64; 2]) -> String {
        if low == high { self.text(low) } else { format!("{} … {}", self.text(low), self.text(high)) }
    }

    /// What is stated: the value, and its spread.
    pub fn stated(&self) -> [String; 2] {
        [self.text(self.value), self.range(self.spread)]
    }
}

impl Measured {
    /// The median, and the quartiles of this run.
    pub fn found(&self) -> [String; 2] {
        [self.figure.text(self.found.median), self.figure.range(self.found.quartiles)]
    }

    pub fn is_within(&self) -> bool {
        let [low, high] = self.figure.spread;
        (low..=high).contains(&self.found.median)
    }

    pub fn json(&self) -> Value {
        json!({
            "name": self.figure.name,
            "measured": self.found.json(),
            "stated": { "value": self.figure.value, "spread": self.figure.spread },
            "within": self.is_within(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const README: &str = include_str!("../../README.md");

    #[test]
    fn the_readme_states_these_figures_and_none_else() {
        let head = "| figure | value | expected within |\n|---|---|---|\n";
        let row = |figure: &Figure| {
            let [value, spread] = figure.stated();
            format!("| {} | {value} | {spread} |\n", figure.name)
        };
        let table: String = std::iter::once(head.to_owned()).chain(FIGURES.iter().map(row)).collect();
        assert!(
            README.contains(&format!("{table}\n")),
            "the README's section \"Measured\" should hold\n\n{table}"
        );
        assert!(README.contains(MACHINE), "the README should name the machine: {MACHINE}");
    }

    #[test]
    fn stated_values_lie_within_their_spread() {
        for figure in &FIGURES {
            let found = Spread::of(vec![figure.value]);
            assert!(Measured { figure, found }.is_within(), "{}", figure.name);
        }
    }

    #[test]
    fn figures_are_found_where_records_have_them_and_nowhere_else() {
        let times = |median: f64| json!({ "median": median, "quartiles": [median, median] });
        let map = |evaluator: &str, tolerance: f64, ratio: Value| {
            json!({
                "evaluator": evaluator, "plane": "parallel", "elements": 256, "width": 1024, "tolerance": tolerance,
                "error": tolerance / 2.0, "new_drive_ratio": ratio, "new_plane_ratio": null,
            })
        };
        let report = json!({
            "field": [map("gpu", 1e-3, times(9.0)), map("cpu", 1e-2, times(8.0)), map("cpu", 1e-3, times(7.0))],
            "shapes": [
                { "drawing": "A", "drive": "end", "evenness": 0.95, "side_lobe": 0.42 },
                { "drawing": "all", "drive": "first drive", "evenness": { "least": 0.94 }, "side_lobe": { "mean": 0.8 } },
                { "drawing": "all", "drive": "end", "evenness": { "least": 0.9 }, "side_lobe": { "mean": 0.45 } },
            ],
            "window": [{ "what": "nothing happens", "frames": 3 }],
        });
        let found: Vec<_> = measured(&report).iter().map(|figure| figure.found.median).collect();
        assert_eq!(found, [7.0, 5e-4, 0.9, 0.45, 3.0]);
        assert!(measured(&json!({})).is_empty());
    }
}
