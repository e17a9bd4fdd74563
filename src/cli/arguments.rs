//! Parsers of argument values, and messages about invalid arguments.

use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::error::Error;
use clap::{Args, Command};
use glam::DVec3;

use crate::echo;
use crate::scene::{Listener, check};
use crate::studio::evaluator::Backend;
use crate::studio::output;

/// Limit of a message about arguments.
const MOST_BYTES: usize = 1900;

/// Invalid arguments, already reported.
#[derive(Debug)]
pub struct BadArguments;

impl fmt::Display for BadArguments {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("bad arguments")
    }
}

impl std::error::Error for BadArguments {}

/// The argument `--drive`.
#[derive(Args, Clone, Debug)]
pub struct DriveArgs {
    /// Drive of your own, instead of the solver's: CSV as of `solve --csv`
    ///
    /// A row per element: phase (rad) or re and im; optionally element, amplitude (0 to 1), x, y and z, which must be the
    /// scene's, and frame for several drives. Or a row per drive, as of `solve --motion --csv`. Nothing is solved. Several
    /// drives take turns, or are the frames of the motion if the scene moves or the file has a column time (s).
    #[arg(long, value_name = "FILE.csv")]
    pub drive: Option<PathBuf>,
}

/// Prints clap's help, version or error.
///
/// # Errors
/// [`BadArguments`], or a standard output that cannot be written.
pub fn answer(error: &Error) -> anyhow::Result<()> {
    if error.use_stderr() {
        let _ = writeln!(io::stderr(), "{}", shown(error).trim_end());
        return Err(BadArguments.into());
    }
    drop(output::standard()?);
    error.print().and_then(|()| io::stdout().flush()).map_err(output::unsaid)
}

/// Refuses a first word that is neither a command nor a file, and suggests a similar command.
///
/// # Errors
/// [`BadArguments`].
pub fn refuse_misspelt(commands: &Command) -> anyhow::Result<()> {
    /// Least Jaro-Winkler similarity of a suggestion.
    const SIMILAR: f64 = 0.85;
    let Some(word) = std::env::args_os().nth(1).and_then(|word| word.into_string().ok()) else {
        return Ok(());
    };
    let is_word = !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase());
    let mut names = commands.get_subcommands().map(|command| command.get_name()).chain(["help"]);
    if !is_word || names.any(|name| name == word) || Path::new(&word).exists() {
        return Ok(());
    }
    let similarity = |name: &str| strsim::jaro_winkler(name, &word);
    let nearest = commands
        .get_subcommands()
        .map(|command| command.get_name())
        .max_by(|a, b| similarity(a).total_cmp(&similarity(b)))
        .filter(|name| similarity(name) >= SIMILAR);
    let hint = nearest.map_or_else(String::new, |name| format!("; did you mean `{name}`?"));
    let _ = writeln!(io::stderr(), "error: {}: no such command or file{hint}", echo::value(&word));
    Err(BadArguments.into())
}

/// Clap's message, with arguments escaped and truncated.
fn shown(error: &Error) -> String {
    let mut text = error.render().to_string();
    for argument in std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()) {
        let value = argument.split_once('=').map_or("", |(_, value)| value);
        for whole in [argument.as_str(), value] {
            let shown = echo::value(whole);
            if shown != whole {
                text = text.replace(whole, &shown);
            }
        }
    }
    let text = echo::lines(&text);
    text[..text.floor_char_boundary(MOST_BYTES)].to_owned()
}

#[derive(Clone, Copy, Debug, Args)]
pub struct BackendArgs {
    /// Evaluator of the field
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    pub backend: Backend,
}

/// Parser of numbers within a range.
pub fn between([least, most]: [f64; 2], unit: &str) -> impl Fn(&str) -> Result<f64, String> + Clone + use<> {
    let wanted = format!("give a number from {least} to {most} {unit}");
    move |text| number(text).filter(|number| (least..=most).contains(number)).ok_or_else(|| wanted.clone())
}

/// Parser of positive numbers; `what` names the quantity and its unit.
pub fn above_zero(most: f64, what: &str) -> impl Fn(&str) -> Result<f64, String> + Clone + use<> {
    let wanted = format!("give {what} above 0, {most} at most");
    move |text| number(text).filter(|number| *number > 0.0 && *number <= most).ok_or_else(|| wanted.clone())
}

/// Parser of positive durations, s.
pub fn seconds(most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone + use<> {
    above_zero(most, "a number of seconds")
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok()
}

/// `N` numbers separated by commas.
pub fn numbers<T: FromStr, const N: usize>(text: &str) -> Option<[T; N]> {
    let numbers: Result<Vec<T>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    numbers.ok()?.try_into().ok()
}

/// A position X,Y,Z, m.
pub fn parse_place(text: &str) -> Result<DVec3, String> {
    /// m; larger coordinates are in a wrong unit.
    const FARTHEST: f64 = 1e6;
    numbers(text)
        .map(DVec3::from_array)
        .filter(|place| place.abs().max_element() <= FARTHEST && place.is_finite())
        .ok_or_else(|| "give three numbers in metres: X,Y,Z".to_owned())
}

pub fn parse_listener(text: &str) -> Result<Listener, String> {
    parse_place(text).map(|at| Listener { at })
}

/// Duration of the further search, s.
pub fn parse_search(text: &str) -> Result<f64, String> {
    let search = text.trim().parse().map_err(|_| "give a time in seconds".to_owned())?;
    check::search(search).map_err(|error| error.message)?;
    Ok(search)
}
