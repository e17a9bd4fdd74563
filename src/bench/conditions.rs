//! What a measurement depends on besides the program: machine, versions, load, date and command.

use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

use crate::field::gpu::adapter;
use crate::simd::Isa;

/// How things stand when a benchmark begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditions {
    /// As the system calls it, where it does.
    processor: Option<String>,
    threads: usize,
    /// Names of the instruction sets, the best last.
    instructions: Vec<&'static str>,
    /// GPU adapters with their drivers, the best first.
    adapters: Vec<String>,
    /// Runnable threads of the whole machine over the last minute, where the system tells.
    load: Option<f64>,
    /// UTC, as 2026-11-21 20:15.
    date: String,
    command: String,
}

impl Conditions {
    pub fn now() -> Self {
        let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |passed| passed.as_secs());
        Self {
            processor: processor(),
            threads: rayon::current_num_threads(),
            instructions: Isa::available().iter().map(|isa| isa.name()).collect(),
            adapters: adapter::adapters().iter().map(ToString::to_string).collect(),
            load: load(),
            date: utc(seconds),
            command: command(std::env::args().skip(1)),
        }
    }

    /// Heading and text, row by row.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let adapters = if self.adapters.is_empty() { "none".to_owned() } else { self.adapters.join("; ") };
        let load = match self.load {
            Some(load) => format!("{load:.2} threads ran on the machine in the minute before"),
            None => "unknown".to_owned(),
        };
        vec![
            ("Processor", self.processor.clone().unwrap_or_else(|| "unknown".to_owned())),
            ("Threads", self.threads.to_string()),
            ("Instructions", format!("{} (of {})", Isa::best().name(), self.instructions.join(", "))),
            ("System", format!("{}, {}", std::env::consts::OS, std::env::consts::ARCH)),
            ("GPU adapters", adapters),
            ("Program", format!("sonoglyph {}, {}", env!("CARGO_PKG_VERSION"), built())),
            ("Load", load),
            ("Begun", format!("{} UTC", self.date)),
            ("Command", self.command.clone()),
        ]
    }

    pub fn json(&self) -> Value {
        json!({
            "machine": {
                "processor": self.processor,
                "threads": self.threads,
                "instructions": Isa::best().name(),
                "architecture": std::env::consts::ARCH,
                "system": std::env::consts::OS,
                "adapters": self.adapters,
                "load": self.load,
            },
            "version": env!("CARGO_PKG_VERSION"),
            "compiler": option_env!("SONOGLYPH_RUSTC"),
            "optimised": is_optimised(),
            "date": self.date,
            "command": self.command,
        })
    }
}

/// Times of a build for debugging mean nothing.
pub fn is_optimised() -> bool {
    !cfg!(debug_assertions)
}

fn built() -> String {
    let compiler = option_env!("SONOGLYPH_RUSTC").unwrap_or("an unknown compiler");
    let how = if is_optimised() { "" } else { ", for debugging: its times mean nothing" };
    format!("built by {compiler}{how}")
}

fn processor() -> Option<String> {
    let known = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let model = known.lines().find_map(|line| line.strip_prefix("model name"))?;
    Some(model.trim_start_matches([' ', '\t', ':']).to_owned())
}

fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split(' ').next()?.parse().ok()
}

/// As it would be typed, whatever the program is called here.
fn command(arguments: impl Iterator<Item = String>) -> String {
    std::iter::once("sonoglyph".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// Date and time of the Gregorian calendar from seconds since 1970.
fn utc(seconds: u64) -> String {
    let is_leap =
        |year: u64| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let (mut day, mut year, mut month) = (seconds / 86_400, 1970, 0);
    while day >= 365 + u64::from(is_leap(year)) {
        day -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let months = [31, 28 + u64::from(is_leap(year)), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    while day >= months[month] {
        day -= months[month];
        month += 1;
    }
    let (hour, minute) = (seconds / 3600 % 24, seconds / 60 % 60);
    format!("{year}-{:02}-{:02} {hour:02}:{minute:02}", month + 1, day + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        let dates = [0, 951_782_399, 951_782_400, 1_709_251_199, 1_735_689_600, 4_107_542_400].map(utc);
        let expected = [
            "1970-01-01 00:00",
            "2000-02-28 23:59",
            "2000-02-29 00:00",
            "2024-02-29 23:59",
            "2025-01-01 00:00",
        ];
        assert_eq!(dates[..5], expected);
        // 2100 is no leap year.
        assert_eq!(dates[5], "2100-03-01 00:00");
    }

    #[test]
    fn every_condition_is_told() {
        let conditions = Conditions::now();
        assert!(conditions.rows().iter().all(|(_, text)| !text.is_empty()), "{conditions:?}");
        assert_eq!(conditions.json()["machine"]["instructions"], Isa::best().name());
    }
}
