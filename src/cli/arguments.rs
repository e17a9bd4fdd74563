//! What is said of arguments that make no sense, and the help.

use std::fmt;
use std::io::{self, Write};

use clap::error::Error;

use crate::cli::Next;
use crate::echo;
use crate::studio::output;

/// Bytes of what is said of arguments, at most.
const MOST: usize = 1900;

/// The arguments make no sense, and that has been said.
#[derive(Debug)]
pub struct BadArguments;

impl fmt::Display for BadArguments {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("bad arguments")
    }
}

impl std::error::Error for BadArguments {}

/// Prints the help or the version that was asked for, or what is wrong.
///
/// # Errors
/// [`BadArguments`], and a standard output that takes nothing.
pub fn answer(error: &Error) -> anyhow::Result<Next> {
    if error.use_stderr() {
        let _ = writeln!(io::stderr(), "{}", shown(error).trim_end());
        return Err(BadArguments.into());
    }
    drop(output::standard()?);
    error.print().and_then(|()| io::stdout().flush()).map_err(output::unsaid)?;
    Ok(Next::Exit)
}

/// What clap says, with the arguments as messages show them.
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
    text[..text.floor_char_boundary(MOST)].to_owned()
}
