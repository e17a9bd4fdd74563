//! The command line: every command with its arguments and help, dispatched to one module per command.

mod animate;
mod arguments;
pub mod batch;
mod boards;
mod devices;
mod elements;
mod figure;
mod interrupt;
mod levitate;
mod manual;
mod motion;
mod names;
mod probe;
mod progress;
mod render;
mod solve;
mod space;
mod time_course;
mod volume;

use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::acoustics::Aperture;
use crate::bench::{self, BenchArgs};
pub use crate::cli::arguments::BadArguments;
use crate::cli::boards::serve::{self, ServeArgs};
use crate::cli::boards::{BoardArgs, CheckArgs, SendArgs};
use crate::cli::elements::ElementsArgs;
use crate::cli::figure::FigureArgs;
use crate::cli::levitate::LevitateArgs;
use crate::cli::manual::{CompletionsArgs, ManualArgs};
use crate::cli::space::SpaceArgs;
use crate::cli::time_course::TimeArgs;
use crate::cli::volume::VolumeArgs;
use crate::field::Quantity;
use crate::picture::ColourMap;
use crate::scene::{Listener, Method, Scene};
use crate::studio::animate::RATES;
use crate::studio::evaluator::{Backend, Renderer};
use crate::studio::output::Files;
use crate::studio::still::{Diagram, Moment, Size};
use crate::studio::{opening, output, reach};

/// Version, with the commit in builds by `./release`.
const VERSION: &str = env!("SONOGLYPH_VERSION");
/// Width of the name column of printed answers.
const COLUMN: usize = 24;

/// Draw a shape, see the ultrasound field of a phased array, feel it in the air.
///
/// Without a command, the window opens on the scene (or an example). Without a display, the scene is solved and its
/// sheet written to sonoglyph.png: targets, phase and amplitude per element, and a map of RMS pressure.
#[derive(Debug, Parser)]
#[command(name = "sonoglyph", version = VERSION, args_conflicts_with_subcommands = true, max_term_width = 100)]
struct Cli {
    /// Scene file (TOML; assets/scenes holds examples), or a link `sonoglyph:#…`.
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
    #[command(verbatim_doc_comment)]
    Levitate(LevitateArgs),
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
    /// The exit status is 0 if every step passed. The board is silent at the end. Examples:
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

#[derive(Debug, Args)]
struct RenderArgs {
    /// Scene files
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// A file, or a folder for one PNG per scene
    #[arg(short, long)]
    output: PathBuf,
    /// Quantity or page to draw
    #[arg(long, value_enum, default_value_t = Diagram::Map(Quantity::Rms))]
    quantity: Diagram,
    /// Pixels: W (keeps the aspect ratio) or WxH [default: 512, pages 1600, films of shaded surfaces 800]
    #[arg(long, value_name = "W[xH]", value_parser = render::parse_size)]
    size: Option<Size>,
    /// Map, shaded liquid surface, or 3D view
    #[arg(long, value_enum, default_value_t = View::Flat)]
    view: View,
    /// Solver method, instead of the scene's
    #[arg(long, value_parser = names::method())]
    method: Option<Method>,
    #[command(flatten)]
    backend: BackendArgs,
    /// Error tolerance relative to the map's peak, or `exact`, instead of the scene's
    ///
    /// A looser tolerance evaluates fewer points and interpolates; `exact` evaluates every pixel.
    #[arg(long, value_name = "T|exact", allow_negative_numbers = true, value_parser = render::parse_tolerance)]
    tolerance: Option<f64>,
    /// Colour map of pressure maps
    #[arg(long, value_enum, default_value_t = ColourMap::Inferno)]
    colours: ColourMap,
    /// Also write the values: NPY, float32, (H, W), row 0 at the smallest y
    ///
    /// Pressure in Pa, phase in rad, depression in m (positive down), intensity in W/m², velocity in m/s, potential in
    /// J, force in N. For --waves the shape is (frames, H, W), and FILE.times.npy has the times (s) of the frames. For
    /// `drive` it is (2, rows, columns): phase in rad, and the solver's amplitude before it is made uniform.
    #[arg(long, value_name = "FILE.npy")]
    data: Option<PathBuf>,
    /// Animate a cycle of the scene's motion: FILE.gif, an animated FILE.png or FILE.apng, FILE.mp4 or FILE.webm, or
    /// a PNG per frame in FOLDER/
    ///
    /// All frames share one range of colours or depths. MP4 (H.264) and WebM (VP9) need ffmpeg and have even sides.
    #[arg(long)]
    motion: bool,
    /// Animate the waves on a liquid from the onset of the sound, for --quantity depression or caustic
    ///
    /// Modulation and motion are those of the scene. Walls, 14 capillary lengths beyond the plane, reflect the waves.
    #[arg(long, conflicts_with = "motion")]
    waves: bool,
    /// Duration of --waves [default: a cycle of the motion, or 0.25 s of a static scene]
    #[arg(long, value_name = "S", requires = "waves")]
    seconds: Option<f64>,
    /// Playback rate of --motion and --waves, frames per second [default: real time, at most 50]
    #[arg(long, value_name = "N", value_parser = arguments::between(RATES, "frames per second"))]
    fps: Option<f64>,
    /// Still picture of a motion: a frame, counted from 1, or the mean over a cycle
    ///
    /// Default: the targets at the scene's positions; for `radiation`, `depression` and `caustic` the mean, since a
    /// liquid is too slow for single frames.
    #[arg(long, value_name = "N|mean", value_parser = render::parse_moment, conflicts_with_all = ["motion", "waves"])]
    frame: Option<Moment>,
    /// Report evaluator, method and times
    #[arg(short, long)]
    verbose: bool,
    #[command(flatten)]
    figure: FigureArgs,
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    space: SpaceArgs,
}

#[derive(Debug, Args)]
struct SolveArgs {
    /// Scene file
    scene: PathBuf,
    /// Solver method, instead of the scene's
    #[arg(long, value_parser = solve::methods())]
    method: Option<solve::Methods>,
    /// Print JSON; an array of objects for `--method all`
    #[arg(long)]
    json: bool,
    /// Write the drive: element, x, y (m), phase (rad), amplitude
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Quality on a board with L phase levels per period, rounded and refined; --csv writes the refined drive
    #[arg(long, value_name = "L", value_parser = clap::value_parser!(u32).range(2..=65536))]
    levels: Option<u32>,
    /// Solve every frame of the scene's motion, each starting from the previous one
    ///
    /// --csv then writes a row per frame: frame, time (s), and phase_0, phase_1, ... (rad), `nan` for elements that are
    /// off. --json prints one object whose `frames` hold time, foci, pressures (Pa, peak) and phases.
    #[arg(long, conflicts_with = "levels")]
    motion: bool,
    /// Duration of the further search (s), instead of the scene's
    #[arg(long, value_name = "S", conflicts_with = "motion", allow_negative_numbers = true, value_parser = arguments::parse_search)]
    search: Option<f64>,
    /// Exposure at a listener's position (m), instead of the scene's
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = arguments::parse_listener)]
    listener: Option<Listener>,
}

#[derive(Debug, Args)]
struct ProbeArgs {
    /// Scene file
    scene: PathBuf,
    /// CSV with the columns x, y, z (m)
    #[arg(long, value_name = "FILE.csv")]
    points: PathBuf,
    #[command(flatten)]
    backend: BackendArgs,
    /// Drive in the format of `solve --csv`, instead of the solver's
    #[arg(long, value_name = "FILE.csv")]
    drive: Option<PathBuf>,
    /// Computed quantity
    ///
    /// `force`: Gor'kov potential, radiation force on the scene's `[bead]` without its weight, and the symmetric part
    /// of the stiffness -dF/dx, in f64 from analytic derivatives; the mean over several drives.
    #[arg(long, value_enum, default_value_t = Probed::Pressure, conflicts_with = "time")]
    quantity: Probed,
    #[command(flatten)]
    time: TimeArgs,
    /// Output file [default: standard output]
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Probed {
    /// Complex peak pressure, and RMS
    Pressure,
    /// Radiation force on the scene's bead
    Force,
}

#[derive(Debug, Args)]
struct BatchArgs {
    /// Solver method, instead of the scenes'
    #[arg(long, value_parser = names::method())]
    method: Option<Method>,
    /// Omit what takes longer than the drive: bound, side lobe, traps and, without --field, widths
    #[arg(long)]
    no_limits: bool,
    /// Add peak, its position and the mean of the RMS pressure on the scene's plane
    #[arg(long)]
    field: bool,
    /// Also write the RMS pressure on the plane: FOLDER/LINE.npy, float32, row 0 at the smallest y; implies --field
    #[arg(long, value_name = "FOLDER")]
    data: Option<PathBuf>,
    /// Threads [default: number of cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Pixels of the field along x
    #[arg(long, value_name = "W", default_value_t = 256, value_parser = clap::value_parser!(u16).range(2..=4096))]
    size: u16,
}

#[derive(Clone, Copy, Debug, Args)]
struct BackendArgs {
    /// Evaluator of the field
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    backend: Backend,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum View {
    /// Map on the scene's plane
    Flat,
    /// Liquid surface as a shaded relief
    Shaded,
    /// Isosurface or projection of the field, with boards, targets and the scene's plane
    #[value(name = "3d")]
    Space,
}

/// Runs the program's command line.
///
/// # Errors
/// Bad input, or output that cannot be written, with a message for the user.
pub fn run() -> anyhow::Result<Next> {
    output::outlive_file_limits()?;
    arguments::refuse_misspelt()?;
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return arguments::answer(&error),
    };
    if let Some(Command::Render(args)) = &cli.command {
        space::refuse(args)?;
    }
    let done = match cli {
        Cli { command: Some(Command::Render(args)), .. } if args.motion || args.waves => animate::run(&args),
        Cli { command: Some(Command::Render(args)), .. } => match (args.volume.volume, args.view) {
            (Some(counts), _) => volume::run(&args, counts),
            (None, View::Space) => space::run(&args),
            (None, View::Flat | View::Shaded) => render::run(&args),
        },
        Cli { command: Some(Command::Solve(args)), .. } if args.motion => motion::run(&args),
        Cli { command: Some(Command::Solve(args)), .. } => solve::run(&args),
        Cli { command: Some(Command::Probe(args)), .. } => probe::run(&args),
        Cli { command: Some(Command::Batch(args)), .. } => batch::run(&args),
        Cli { command: Some(Command::Bench(args)), .. } => bench::run(&args),
        Cli { command: Some(Command::Elements(args)), .. } => elements::run(&args),
        Cli { command: Some(Command::Levitate(args)), .. } => levitate::run(&args),
        Cli { command: Some(Command::Devices), .. } => devices::run(),
        Cli { command: Some(Command::Ports), .. } => boards::ports(),
        Cli { command: Some(Command::Send(args)), .. } => boards::send(&args),
        Cli { command: Some(Command::Serve(args)), .. } => serve::run(&args),
        Cli { command: Some(Command::Check(args)), .. } => boards::check(&args),
        Cli { command: Some(Command::Board(args)), .. } => boards::board(&args),
        Cli { command: Some(Command::Completions(args)), .. } => manual::completions(&args),
        Cli { command: Some(Command::Manual(args)), .. } => manual::run(&args),
        Cli { command: None, scene, renderer } => return Ok(Next::Window(scene, renderer)),
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

/// Reads a scene, with `method` instead of its own. It and its named files are then refused as outputs.
fn read_scene(path: &Path, method: Option<Method>, files: &mut Files) -> anyhow::Result<Scene> {
    files.reads(path)?;
    let mut scene = opening::open(path)?;
    files.reads_files_of(&scene)?;
    if let Some(method) = method {
        scene.solver.method = method;
    }
    reach::cut_short(&Aperture::new(&scene)).iter().for_each(|warning| output::warn(&warning.to_string()));
    Ok(scene)
}

/// Writes to the file, by default to standard output.
fn write_or_print(path: Option<&Path>, text: &str) -> anyhow::Result<()> {
    match path {
        Some(path) => output::write(path, text.as_bytes()),
        None => output::print(format_args!("{text}")),
    }
}
