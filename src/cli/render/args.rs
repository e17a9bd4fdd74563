//! The arguments of `sonoglyph render`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::{DVec3, UVec3};

use crate::cli::arguments::{self, BackendArgs, DriveArgs, between, numbers};
use crate::cli::scene::Source;
use crate::cli::{names, progress};
use crate::field::Quantity;
use crate::field::volume::camera::Standard;
use crate::field::volume::{Block, MOST_POINTS_ALONG};
use crate::picture::ColourMap;
use crate::scene::{Channel, Method};
use crate::studio::animate::RATES;
use crate::studio::figure::{DENSITIES, WIDTHS};
use crate::studio::space::SIDES;
use crate::studio::still::{Diagram, LARGEST_SIDE, Look, Moment, Size};

/// dB relative to the peak, of an isosurface.
const LEVELS: [f64; 2] = [-60.0, -0.1];
/// Columns of a page, at most.
const COLUMNS: i64 = 12;
/// Degrees.
const AZIMUTHS: [f64; 2] = [-360.0, 360.0];
/// m; centres beyond are in a wrong unit.
const FARTHEST: f64 = 100.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum View {
    /// Map on the scene's plane
    Flat,
    /// Liquid surface as a shaded relief
    Shaded,
    /// Isosurface or projection of the field, with boards, targets and the scene's plane
    #[value(name = "3d")]
    Space,
}

#[derive(Debug, Args)]
pub struct RenderArgs {
    /// Scene files
    #[arg(required = true)]
    pub scenes: Vec<PathBuf>,
    /// A file, or a folder for one PNG per scene
    #[arg(short, long)]
    pub output: PathBuf,
    /// Quantity or page to draw
    #[arg(long, value_enum, default_value_t = Diagram::Map(Quantity::Rms))]
    pub quantity: Diagram,
    /// Pixels: W (keeps the aspect ratio) or WxH [default: 512, pages 1600, films of shaded surfaces 800]
    #[arg(long, value_name = "W[xH]", value_parser = parse_size)]
    pub size: Option<Size>,
    /// Map, shaded liquid surface, or 3D view
    #[arg(long, value_enum, default_value_t = View::Flat)]
    pub view: View,
    /// Solver method, instead of the scene's
    #[arg(long, value_parser = names::method(), conflicts_with = "drive")]
    pub method: Option<Method>,
    #[command(flatten)]
    pub drive: DriveArgs,
    #[command(flatten)]
    pub backend: BackendArgs,
    /// Error tolerance relative to the map's peak, or `exact`, instead of the scene's
    ///
    /// A looser tolerance evaluates fewer points and interpolates; `exact` evaluates every pixel.
    #[arg(long, value_name = "T|exact", allow_negative_numbers = true, value_parser = parse_tolerance)]
    pub tolerance: Option<f64>,
    /// Colour map of pressure maps
    #[arg(long, value_enum, default_value_t = ColourMap::Inferno)]
    pub colours: ColourMap,
    /// Also write the values: NPY, float32, (H, W), row 0 at the smallest y
    ///
    /// Pressure in Pa, phase in rad, depression in m (positive down), intensity in W/m², velocity and speed in m/s, potential in
    /// J, force in N, skin in m, felt in dB over threshold. For --waves the shape is (frames, H, W), and FILE.times.npy has the times (s) of the frames. For
    /// `drive` it is (2, rows, columns): phase in rad, and the solver's amplitude before it is made uniform.
    #[arg(long, value_name = "FILE.npy")]
    pub data: Option<PathBuf>,
    /// Animate a cycle of the scene's motion: FILE.gif, an animated FILE.png or FILE.apng, FILE.mp4 or FILE.webm, or
    /// a PNG per frame in FOLDER/
    ///
    /// All frames share one range of colours or depths. MP4 (H.264) and WebM (VP9) need ffmpeg and have even sides.
    #[arg(long)]
    pub motion: bool,
    /// Animate the waves on a liquid from the onset of the sound, for --quantity depression or caustic
    ///
    /// Modulation and motion are those of the scene. Walls, 14 capillary lengths beyond the plane, reflect the waves.
    #[arg(long, conflicts_with = "motion")]
    pub waves: bool,
    /// Duration of --waves [default: a cycle of the motion, or 0.25 s of a static scene]
    #[arg(long, value_name = "S", requires = "waves")]
    pub seconds: Option<f64>,
    /// Playback rate of --motion and --waves, frames per second [default: real time, at most 50]
    #[arg(long, value_name = "N", value_parser = arguments::between(RATES, "frames per second"))]
    pub fps: Option<f64>,
    /// Still picture of a motion: a frame, counted from 1, or the mean over a cycle
    ///
    /// Default: the targets at the scene's positions; for `radiation`, `depression` and `caustic` the mean, since a
    /// liquid is too slow for single frames.
    #[arg(long, value_name = "N|mean", value_parser = parse_moment, conflicts_with_all = ["motion", "waves"])]
    pub frame: Option<Moment>,
    /// Frequencies that count for `skin` and `felt`: pressure (below 20 Hz), flutter (20 to 60 Hz), vibration (above)
    #[arg(long, value_parser = names::channel(), default_value = Channel::All.into_str())]
    pub channel: Channel,
    /// Report evaluator, method and times
    #[arg(short, long)]
    pub verbose: bool,
    #[command(flatten)]
    pub figure: FigureArgs,
    #[command(flatten)]
    pub pattern: PatternArgs,
    #[command(flatten)]
    pub volume: VolumeArgs,
    #[command(flatten)]
    pub space: SpaceArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Figures")]
pub struct FigureArgs {
    /// Draw a figure for a paper, with axes and a colour bar: .png, .svg or .pdf
    #[arg(long, conflicts_with_all = ["size", "motion", "waves"])]
    pub figure: bool,
    /// Width of the figure in mm [default: 85, one column]
    #[arg(long, value_name = "W", requires = "figure", value_parser = between(WIDTHS, "mm"))]
    pub width_mm: Option<f64>,
    /// All scenes as panels of one page with this many columns; maps share one range of colours
    #[arg(long, value_name = "N", requires = "figure", value_parser = clap::value_parser!(u16).range(1..=COLUMNS))]
    pub columns: Option<u16>,
    /// Dots per inch of the map, and of a PNG [default: 300]
    #[arg(long, value_name = "D", requires = "figure", value_parser = between(DENSITIES, "dots per inch"))]
    pub dpi: Option<f64>,
    /// Logarithmic colours, in dB relative to the largest value
    #[arg(long, requires = "figure")]
    pub db: bool,
    /// Values of the first and the last colour: Pa, m, W/m², m/s or × undisturbed; with --db in dB
    #[arg(long, value_name = "A,B", requires = "figure", allow_hyphen_values = true, value_parser = parse_range)]
    pub range: Option<[f64; 2]>,
    /// Contour lines at these levels, in dB relative to the largest value: -6, or -3,-6,-12; of what is felt over the threshold: 0,10,20
    #[arg(long, value_name = "L", requires = "figure", allow_hyphen_values = true, value_delimiter = ',', value_parser = parse_level)]
    pub contours: Vec<f64>,
    /// Draw targets: strokes as lines, foci as rings
    #[arg(long, requires = "figure")]
    pub targets: bool,
    /// Draw the -6 dB widths of separate foci along both axes
    #[arg(long, requires = "figure")]
    pub widths: bool,
    /// Draw the vector behind velocity, speed, intensity, gorkov or force in the plane: a longer arrow is stronger
    #[arg(long, requires = "figure")]
    pub arrows: bool,
    /// Draw a scale bar on the map
    #[arg(long, requires = "figure")]
    pub scale_bar: bool,
    /// Title above the map
    #[arg(long, value_name = "T", requires = "figure")]
    pub title: Option<String>,
    /// Colours for a light background: silence is white; also for --view 3d
    #[arg(long)]
    pub light: bool,
    /// State pressures as peak amplitudes instead of RMS
    #[arg(long, requires = "figure")]
    pub peak: bool,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Beam pattern")]
pub struct PatternArgs {
    /// Beam pattern: level (dB) against angle (degrees) in the far field, as FILE.csv or a figure: .png, .svg, .pdf
    ///
    /// The angle is that from the normal of the (first) board. Prints main lobe, widths, nulls and side lobes.
    #[arg(long, conflicts_with_all = ["quantity", "view", "size", "data", "motion", "waves", "volume"])]
    pub pattern: bool,
    /// Azimuths of its cuts, in degrees from x to y [default: 0,90; for an oblique beam through it and across]
    #[arg(long, value_name = "DEG", requires = "pattern", allow_hyphen_values = true, value_delimiter = ',', value_parser = between(AZIMUTHS, "degrees"))]
    pub cut: Vec<f64>,
    /// Print lobes and widths as JSON, in degrees and dB
    #[arg(long, requires = "pattern")]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Space")]
pub struct SpaceArgs {
    /// View direction: iso, top, front, side, or azimuth and elevation in degrees
    #[arg(long, value_name = "VIEW|A,E", allow_hyphen_values = true, value_parser = parse_camera)]
    pub camera: Option<[f64; 2]>,
    /// Isosurface of the RMS pressure, in dB relative to the peak [default: -6]
    #[arg(long, value_name = "DB", allow_hyphen_values = true, value_parser = between(LEVELS, "dB"), conflicts_with = "projection")]
    pub iso: Option<f64>,
    /// Maximum-intensity projection of the RMS pressure, instead of an isosurface
    #[arg(long)]
    pub projection: bool,
    /// Slices through the field, at positions in m: z=0.1 or x=0,y=0.01
    #[arg(long, value_name = "AXIS=M", value_delimiter = ',', value_parser = parse_slice)]
    pub slice: Vec<(usize, f64)>,
    /// Parallel projection instead of perspective
    #[arg(long)]
    pub parallel: bool,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Volumes")]
pub struct VolumeArgs {
    /// Write the quantity at NX x NY x NZ points: FILE.vti (VTK ImageData) or FILE.npy, shape (NZ, NY, NX)
    ///
    /// Values are float32, in the units of --data, at the centres of cells that fill the box.
    #[arg(long, value_name = "NX,NY,NZ", value_parser = parse_counts, conflicts_with_all = ["size", "motion", "waves", "figure", "data"])]
    pub volume: Option<UVec3>,
    /// Box of --volume and --view 3d: size, then centre (m) [default: plane, targets, most of the way to the boards]
    #[arg(long = "box", value_name = "SX,SY,SZ,CX,CY,CZ", allow_hyphen_values = true, value_parser = parse_block)]
    pub block: Option<Block>,
}

impl RenderArgs {
    /// The source of the drive.
    pub fn source(&self) -> Source<'_> {
        Source { method: self.method, drive: self.drive.drive.as_deref() }
    }
}

/// The options common to all pictures.
pub fn look(args: &RenderArgs) -> Look {
    Look {
        diagram: args.quantity,
        shaded: args.view == View::Shaded,
        colours: args.colours,
        channel: args.channel,
        size: args.size,
        numbers: args.data.is_some(),
        backend: args.backend.backend,
        moment: args.frame,
        begin: progress::begin,
    }
}

/// `W` or `WxH`.
pub fn parse_size(text: &str) -> Result<Size, String> {
    let side = |text: &str| match text.parse::<usize>() {
        Ok(side) if (1..=LARGEST_SIDE).contains(&side) => Ok(side),
        _ => Err(format!("`{text}` is not a number of pixels from 1 to {LARGEST_SIDE}")),
    };
    match text.split_once(['x', 'X']) {
        Some((width, height)) => Ok(Size { width: side(width)?, height: Some(side(height)?) }),
        None => Ok(Size { width: side(text)?, height: None }),
    }
}

pub fn parse_moment(text: &str) -> Result<Moment, String> {
    match text.parse::<usize>() {
        _ if text == "mean" => Ok(Moment::Mean),
        Ok(number) if number > 0 => Ok(Moment::Frame(number - 1)),
        _ => Err("give a frame's number, counted from 1, or `mean`".to_owned()),
    }
}

pub fn parse_tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        _ if text == "exact" => Ok(0.0),
        // 0 evaluates every pixel, as in a scene.
        Ok(tolerance) if (0.0..1.0).contains(&tolerance) => Ok(tolerance.abs()),
        _ => Err("give a number from 0 (`exact`) to below 1".to_owned()),
    }
}

fn parse_range(text: &str) -> Result<[f64; 2], String> {
    numbers(text)
        .filter(|&[low, high]: &[f64; 2]| low < high && low.is_finite() && high.is_finite())
        .ok_or_else(|| "give two numbers, the smaller first: A,B".to_owned())
}

fn parse_level(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(level) if (-200.0..=200.0).contains(&level) => Ok(level),
        _ => {
            Err("give a number of dB: below 0, such as -6, or over the threshold for what is felt".to_owned())
        }
    }
}

fn parse_camera(text: &str) -> Result<[f64; 2], String> {
    if let Ok(standard) = text.parse::<Standard>() {
        return Ok(standard.direction());
    }
    numbers(text)
        .filter(|&[azimuth, elevation]: &[f64; 2]| azimuth.abs() <= 360.0 && elevation.abs() <= 90.0)
        .map(|direction| direction.map(f64::to_radians))
        .ok_or_else(|| {
            "give iso, top, front, side, or an azimuth from -360 to 360 and an elevation from -90 to 90 degrees: A,E"
                .to_owned()
        })
}

fn parse_slice(text: &str) -> Result<(usize, f64), String> {
    let parts = text.split_once('=');
    let axis = parts.and_then(|(name, _)| ["x", "y", "z"].iter().position(|axis| *axis == name.trim()));
    match (axis, parts.map(|(_, place)| place.trim().parse::<f64>())) {
        (Some(axis), Some(Ok(place))) if place.abs() <= 100.0 => Ok((axis, place)),
        _ => Err("give an axis and a place in metres, such as z=0.1".to_owned()),
    }
}

fn parse_counts(text: &str) -> Result<UVec3, String> {
    numbers(text)
        .filter(|counts: &[u32; 3]| counts.iter().all(|count| (1..=MOST_POINTS_ALONG).contains(count)))
        .map(UVec3::from_array)
        .ok_or_else(|| format!("give three numbers of points, each from 1 to {MOST_POINTS_ALONG}: NX,NY,NZ"))
}

fn parse_block(text: &str) -> Result<Block, String> {
    let Some([sx, sy, sz, x, y, z]) = numbers(text) else {
        return Err("give six numbers in metres, size and centre: SX,SY,SZ,CX,CY,CZ".to_owned());
    };
    let [least, most] = SIDES;
    let (size, centre) = (DVec3::new(sx, sy, sz), DVec3::new(x, y, z));
    if !size.to_array().iter().all(|side| (least..=most).contains(side)) {
        return Err(format!("give sides from {least} to {most} m"));
    }
    if !centre.to_array().iter().all(|place| place.abs() <= FARTHEST) {
        return Err(format!("give a centre with coordinates from -{FARTHEST} to {FARTHEST} m"));
    }
    Ok(Block { centre, size })
}
