//! The command line: every command with its arguments and help, dispatched to one module per command.

mod arguments;
pub mod batch;
mod boards;
mod devices;
mod elements;
mod interrupt;
mod levitate;
mod manual;
mod measure;
mod motion;
mod names;
mod probe;
mod progress;
mod render;
mod scene;
mod solve;
mod time_course;

use std::path::PathBuf;

use clap::{CommandFactory, Parser, Subcommand};

use crate::bench::{self, BenchArgs};
pub use crate::cli::arguments::BadArguments;
use crate::cli::batch::BatchArgs;
use crate::cli::boards::arguments::BoardArgs;
use crate::cli::boards::check::{self, CheckArgs};
use crate::cli::boards::send::{self, SendArgs};
use crate::cli::boards::serve::{self, ServeArgs};
use crate::cli::boards::{board, ports};
use crate::cli::elements::ElementsArgs;
use crate::cli::levitate::LevitateArgs;
use crate::cli::manual::{CompletionsArgs, ManualArgs};
use crate::cli::measure::args::MeasureArgs;
use crate::cli::probe::ProbeArgs;
use crate::cli::render::args::RenderArgs;
use crate::cli::solve::SolveArgs;
use crate::studio::evaluator::Renderer;
use crate::studio::output;

/// Version, with the commit in builds by `./release`.
const VERSION: &str = env!("SONOGLYPH_VERSION");

/// Draw a shape, see the ultrasound field of a phased array, feel it in the air.
///
/// Without a command, the window opens on the scene (or an example). Without a display, the scene is solved and its
/// sheet written to sonoglyph.png: targets, phase and amplitude per element, and a map of RMS pressure.
#[derive(Debug, Parser)]
#[command(name = "sonoglyph", version = VERSION, args_conflicts_with_subcommands = true, max_term_width = 100)]
struct Cli {
    /// Scene file (TOML; assets/scenes holds examples), a drawing to import, or a link `sonoglyph:#…`.
    scene: Option<PathBuf>,
    /// Renderer of the window
    #[arg(long, value_enum, default_value_t = Renderer::Auto)]
    renderer: Renderer,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Solve scenes and write pictures, animations or volumes
    ///
    /// Maps are drawn y upwards with samples at pixel centres. Examples:
    ///
    ///   sonoglyph render assets/scenes/hit.toml -o hit.png --quantity sheet
    ///
    ///   sonoglyph render assets/scenes/*.toml -o pictures/ --size 1024
    ///
    ///   sonoglyph render water-two-points.toml -o water.png --quantity depression --view shaded
    ///
    ///   sonoglyph render hit.toml -o hit.png --data hit.npy --backend reference
    ///
    ///   sonoglyph render hit.toml -o hit.pdf --figure --contours -6 --targets --scale-bar
    ///
    ///   sonoglyph render levitator.toml -o own.png --drive own.csv
    ///
    ///   sonoglyph render hit.toml -o hit.vti --volume 64,64,64
    ///
    ///   sonoglyph render hit.toml -o hit.png --view 3d --camera iso --iso -6
    ///
    ///   sonoglyph render assets/scenes/water-moving-square.toml --motion -o square.gif
    ///
    ///   sonoglyph render water-moving-square.toml --quantity depression --view shaded --waves -o waves.mp4
    #[command(verbatim_doc_comment)]
    Render(Box<RenderArgs>),
    /// Find the drive of a scene and report its quality
    ///
    /// Examples:
    ///
    ///   sonoglyph solve assets/scenes/hit.toml
    ///
    ///   sonoglyph solve assets/scenes/circle.toml --method all
    ///
    ///   sonoglyph solve hit.toml --json --csv drive.csv
    ///
    ///   sonoglyph solve assets/scenes/water-moving-square.toml --motion --csv frames.csv
    ///
    ///   sonoglyph solve hit.toml --listener 0,-0.4,0.3
    ///
    ///   sonoglyph solve levitator.toml --drive own.csv
    #[command(verbatim_doc_comment)]
    Solve(SolveArgs),
    /// Compute the complex pressure at points from a CSV file
    ///
    /// The file has the columns x, y, z in metres. The answer adds re, im (Pa, peak) and rms (Pa), or for the
    /// scene's bead (--quantity force) gorkov (J), fx, fy, fz (N) and kxx to kzz (N/m). Examples:
    ///
    ///   sonoglyph probe hit.toml --points points.csv -o pressures.csv
    ///
    ///   sonoglyph probe levitator.toml --points points.csv --quantity force
    ///
    ///   sonoglyph probe scene.toml --points points.csv --time --spectrum lines.csv -o course.csv
    #[command(verbatim_doc_comment)]
    Probe(ProbeArgs),
    /// Measure time against error on this machine, relative to a baseline in the same run
    ///
    /// Examples:
    ///
    ///   sonoglyph bench field
    ///
    ///   sonoglyph bench all --json bench.json --plots plots/
    #[command(verbatim_doc_comment)]
    Bench(BenchArgs),
    /// Solve scenes given as JSON lines, and answer with JSON lines in the same order
    ///
    /// A line is a scene with the tables and keys of the scene file; `format` is optional, and an `id` is
    /// returned with the answer: the object of `solve --json`, or {"error": …}. Example:
    ///
    ///   echo '{"target": [{"kind": "point", "at": [0, 0, 0.12]}]}' | sonoglyph batch --field
    #[command(verbatim_doc_comment)]
    Batch(BatchArgs),
    /// Write positions and normals of a scene's elements as CSV, board by board
    ///
    /// The columns are x,y,z (m) and nx,ny,nz: the format of `array.elements` in a scene file. Examples:
    ///
    ///   sonoglyph elements levitator.toml -o levitator.csv
    #[command(verbatim_doc_comment)]
    Elements(ElementsArgs),
    /// Simulate a bead released in a scene's field, or carried along its motion
    ///
    /// The scene's bead moves under radiation force, weight and air drag, for --seconds or until it is more
    /// than a wavelength from its trap. Examples:
    ///
    ///   sonoglyph levitate assets/scenes/levitated-beads.toml
    ///
    ///   sonoglyph levitate trap.toml --from 0,0.002,0.1 --seconds 0.5 -o flight.csv
    ///
    ///   sonoglyph levitate moving-trap.toml --fastest
    ///
    ///   sonoglyph levitate levitator.toml --drive own.csv
    #[command(verbatim_doc_comment)]
    Levitate(LevitateArgs),
    /// Plan a microphone scan, and identify the elements' gains and phases from its readings
    ///
    /// Random drives are played while a plotter moves a microphone over a plane; the readings, with or without
    /// phases, tell gain and phase of every element, dead and reversed ones, strength, speed of sound and the
    /// scan's place, with standard errors. docs/measuring.md is the guide. Examples:
    ///
    ///   sonoglyph measure array.toml --plan -o scan/
    ///
    ///   sonoglyph measure array.toml --plan -o scan/ --port /dev/ttyUSB0 --profile sonicsurface
    ///
    ///   sonoglyph measure array.toml --scan scan/scan.csv -o calibration.csv --report report.html
    ///
    ///   sonoglyph send hit.toml --port /dev/ttyUSB0 --profile sonicsurface --calibration calibration.csv
    #[command(verbatim_doc_comment)]
    Measure(Box<MeasureArgs>),
    /// List GPU adapters and field evaluators, and the automatic choice
    Devices,
    /// List serial ports and supported boards
    Ports,
    /// Play a scene on a board
    ///
    /// A scene at rest is played for a second, a scene with motion for one cycle; --loop plays until Ctrl-C.
    /// The board is silenced whenever the command ends. Examples:
    ///
    ///   sonoglyph send hit.toml --port /dev/ttyUSB0 --profile sonicsurface --loop
    ///
    ///   sonoglyph send hit.toml --port /dev/ttyUSB0 --profile sonicsurface --drive own.csv
    ///
    ///   sonoglyph send moving.toml --port /dev/ttyUSB0 --profile native --baud 3000000 --seconds 20
    #[command(verbatim_doc_comment)]
    Send(SendArgs),
    /// Let other programs edit a scene over OSC and WebSocket, and play it on a board
    ///
    /// docs/control.md has the protocol. Only programs on this machine can connect, unless --listen names
    /// another address. The board is silent until a program starts it; Ctrl-C silences it. Examples:
    ///
    ///   sonoglyph serve hit.toml --osc 9000 --port /dev/ttyUSB0 --profile sonicsurface
    ///
    ///   sonoglyph serve --websocket 9001 --listen 0.0.0.0 --token correct-horse
    #[command(verbatim_doc_comment)]
    Serve(ServeArgs),
    /// Bring up a board: connection, bit rates, each element, a focus, the emergency stop
    ///
    /// The exit status is 0 if no step failed. Boards that do not report what they play leave steps
    /// unverified (?), unless --listen lets you judge. The board is silent at the end. Examples:
    ///
    ///   sonoglyph check --port /dev/ttyUSB0
    ///
    ///   sonoglyph check --port /dev/ttyUSB0 --listen --calibration mine.csv -o report.txt
    #[command(verbatim_doc_comment)]
    Check(CheckArgs),
    /// Emulate a board on a pseudo-terminal: decode the stream and show its field
    ///
    /// Prints the port for `sonoglyph send`. Examples:
    ///
    ///   sonoglyph board --profile sonicsurface --seconds 60 -o field.png
    ///
    ///   sonoglyph board --rtl
    ///
    ///   sonoglyph board --faults drop=0.0001,flip=0.0001,unplug=2
    ///
    ///   sonoglyph board --hidden 7 --positions positions.csv --readings scan.csv --microphone snr=30,width=0.005
    #[command(verbatim_doc_comment)]
    Board(BoardArgs),
    /// Write shell completions to standard output
    ///
    /// Examples:
    ///
    ///   sonoglyph completions bash > ~/.local/share/bash-completion/completions/sonoglyph
    #[command(verbatim_doc_comment)]
    Completions(CompletionsArgs),
    /// Write a manual page (roff) to standard output, or all pages into a folder
    ///
    /// Examples:
    ///
    ///   sonoglyph manual render | man -l -
    ///
    ///   sonoglyph manual -o ~/.local/share/man/man1
    #[command(verbatim_doc_comment)]
    Manual(ManualArgs),
}

/// Runs the program's command line.
///
/// # Errors
/// Bad input, or output that cannot be written, with a message for the user.
pub fn run() -> anyhow::Result<Next> {
    output::outlive_file_limits()?;
    arguments::refuse_misspelt(&Cli::command())?;
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return arguments::answer(&error).map(|()| Next::Exit),
    };
    let Some(command) = cli.command else { return Ok(Next::Window(cli.scene, cli.renderer)) };
    let done = match command {
        Command::Render(args) => render::run(&args),
        Command::Solve(args) if args.motion => motion::run(&args),
        Command::Solve(args) => solve::run(&args),
        Command::Probe(args) => probe::run(&args),
        Command::Batch(args) => batch::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Elements(args) => elements::run(&args),
        Command::Levitate(args) => levitate::run(&args),
        Command::Measure(args) => measure::run(&args),
        Command::Devices => devices::run(),
        Command::Ports => ports::run(),
        Command::Send(args) => send::run(&args),
        Command::Serve(args) => serve::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Board(args) => board(&args),
        Command::Completions(args) => manual::completions(&args, Cli::command()),
        Command::Manual(args) => manual::run(&args, Cli::command()),
    };
    done.map(|()| Next::Exit)
}

/// The step after the command line.
#[derive(Debug)]
pub enum Next {
    Exit,
    /// The window, on this scene or an example.
    Window(Option<PathBuf>, Renderer),
}
