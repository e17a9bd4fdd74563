//! `sonoglyph manual` and `sonoglyph completions`: manual pages and shell completions, generated from the arguments.

use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;

use crate::echo;
use crate::studio::output;

#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// Shell
    #[arg(value_enum)]
    shell: Shell,
}

#[derive(Debug, Args)]
pub struct ManualArgs {
    /// Command of the page [default: the program itself]
    command: Option<String>,
    /// Write the pages of all commands into a folder
    #[arg(short, long, value_name = "FOLDER", conflicts_with = "command")]
    output: Option<PathBuf>,
}

pub fn completions(args: &CompletionsArgs, mut program: Command) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "sonoglyph", &mut script);
    print(&script)
}

pub fn run(args: &ManualArgs, program: Command) -> anyhow::Result<()> {
    let mut program = program.disable_help_subcommand(true);
    // Only a built command knows its full name, such as `sonoglyph-render`.
    program.build();
    if let Some(folder) = &args.output {
        let commands = [&program].into_iter().chain(program.get_subcommands());
        return commands
            .map(page_of)
            .try_for_each(|page| output::write(&folder.join(page.get_filename()), &rendered(&page)?));
    }
    let command = match &args.command {
        None => &program,
        Some(name) => {
            let names: Vec<_> = program.get_subcommands().map(|command| command.get_name()).collect();
            let said = || format!("{}: no such command; there are {}", echo::value(name), names.join(", "));
            program.find_subcommand(name).with_context(said)?
        }
    };
    print(&rendered(&page_of(command))?)
}

fn page_of(command: &Command) -> Man {
    Man::new(command.clone()).manual("Sonoglyph")
}

fn rendered(page: &Man) -> anyhow::Result<Vec<u8>> {
    let mut text = Vec::new();
    page.render(&mut text)?;
    Ok(text)
}

fn print(text: &[u8]) -> anyhow::Result<()> {
    output::print(format_args!("{}", String::from_utf8_lossy(text)))
}
