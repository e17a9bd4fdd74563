//! `sonoglyph serve`: lets other programs edit a scene over the network, and plays it on a board.

use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use crate::cli::boards::arguments::parse_profile;
use crate::cli::interrupt::{self, Interrupted};
use crate::cli::scene::{Source, read_scene};
use crate::control::board::Board;
use crate::control::desk::Desk;
use crate::control::live::Live;
use crate::control::server::{Server, Settings};
use crate::device::health::State;
use crate::device::profile::Profile;
use crate::scene::Scene;
use crate::studio::output::{Files, note, say};

#[derive(Debug, Args)]
pub struct ServeArgs {
    /// Scene file [default: an empty scene]
    scene: Option<PathBuf>,
    /// UDP port for OSC; 0: any free port [default without the three port options: 9000]
    #[arg(long, value_name = "PORT")]
    osc: Option<u16>,
    /// TCP port for WebSocket; 0: any free port [default without the three port options: 9001]
    #[arg(long, value_name = "PORT")]
    websocket: Option<u16>,
    /// UDP port for commands of Ultraino, whose own port is 8085; 0: any free port
    #[arg(long, value_name = "PORT")]
    ultraino: Option<u16>,
    /// Address to listen on; other machines need the token
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    listen: IpAddr,
    /// Password of other machines and of foreign web pages [default: random, if other machines can connect]
    #[arg(long, value_name = "TOKEN")]
    token: Option<String>,
    /// Serial port of a board; `sonoglyph ports` lists them
    #[arg(long, requires = "profile")]
    port: Option<PathBuf>,
    /// Kind of board; `sonoglyph ports` lists them
    #[arg(long, value_parser = parse_profile, requires = "port")]
    profile: Option<Profile>,
    /// Bits per second, instead of the board's default
    #[arg(long, requires = "port", value_parser = clap::value_parser!(u32).range(1200..=12_000_000))]
    baud: Option<u32>,
    /// Corrections: CSV with the columns element, offset (degrees), gain (0 to 1), off (0 or 1), and a row per element;
    /// or the .pat of an OpenMPD board
    #[arg(long, value_name = "FILE", requires = "port")]
    calibration: Option<PathBuf>,
}

pub fn run(args: &ServeArgs) -> anyhow::Result<()> {
    let scene = match &args.scene {
        Some(path) => read_scene(path, Source::default(), &mut Files::new())?,
        None => Scene::default(),
    };
    let interrupted = interrupt::watch()?;
    let board = board(args, &scene, &interrupted)?;
    if interrupted.is_set() {
        return Ok(());
    }
    let plays = board.is_some();
    let desk = Arc::new(Desk::new(Arc::new(scene), Box::new(|| {})));
    let its = Arc::clone(&desk);
    interrupted.then(move || its.silence())?;
    let server = Server::start(settings(args), Arc::clone(&desk))?;
    let mut live = Live::new(Arc::clone(&desk), board);
    for line in server.addresses().lines() {
        say!("{line}")?;
    }
    if let Some(token) = server.token() {
        say!("token {token}")?;
    }
    if !args.listen.is_loopback() {
        note("connections are not encrypted: anyone on the network can read the token");
    }
    note(if plays {
        "the board is silent until a program says send"
    } else {
        "no board: give --port and --profile"
    });
    while !interrupted.is_set() {
        live.turn();
    }
    let health = live.close();
    drop(server);
    say!("{}", desk.counts.tally())?;
    let Some(health) = health else { return Ok(()) };
    match health.state {
        State::Lost(why) => anyhow::bail!("{why}: the board was lost, in an unknown state"),
        State::Connecting | State::Ready if !health.silenced => {
            anyhow::bail!("the board could not be silenced: its port takes no bytes")
        }
        State::Connecting | State::Ready => Ok(()),
    }
}

fn settings(args: &ServeArgs) -> Settings {
    let ServeArgs { osc, websocket, ultraino, listen, .. } = *args;
    let default = Settings { listen, token: args.token.clone(), ..Settings::default() };
    match (osc, websocket, ultraino) {
        (None, None, None) => default,
        (Some(_), _, _) | (_, Some(_), _) | (_, _, Some(_)) => {
            Settings { osc, websocket, ultraino, ..default }
        }
    }
}

/// Opens the link to the board, if one is given.
fn board(args: &ServeArgs, scene: &Scene, interrupted: &Interrupted) -> anyhow::Result<Option<Board>> {
    use anyhow::Context;

    use crate::cli::boards::arguments::calibration;
    use crate::device::link;
    use crate::device::wiring::{Share, Wiring};

    let (Some(port), Some(profile)) = (args.port.clone(), args.profile) else { return Ok(None) };
    let name = args.scene.as_ref().map_or_else(|| "the scene".to_owned(), |path| path.display().to_string());
    Wiring::of(profile, scene, Share::default()).context(name)?;
    let calibration = calibration(args.calibration.as_slice(), scene, None)?;
    let settings = link::Settings { port, profile, baud: args.baud };
    Board::open(settings, calibration, || interrupted.is_set())
}
