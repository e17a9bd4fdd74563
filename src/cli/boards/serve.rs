//! `sonoglyph serve`: a scene that other programs edit, and a board that plays it.

use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use crate::cli::boards::parse_profile;
use crate::cli::interrupt::{self, Interrupted};
use crate::cli::read_scene;
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
    /// Scene file; without one an empty scene, to which others add targets
    scene: Option<PathBuf>,
    /// UDP port for OSC; 0 takes a free one [default, if none of the three is given: 9000]
    #[arg(long, value_name = "PORT")]
    osc: Option<u16>,
    /// TCP port for WebSocket; 0 takes a free one [default, if none of the three is given: 9001]
    #[arg(long, value_name = "PORT")]
    websocket: Option<u16>,
    /// UDP port for the words of Ultraino, which listens at 8085; 0 takes a free one
    #[arg(long, value_name = "PORT")]
    ultraino: Option<u16>,
    /// Address to listen on; other machines than this one need the token
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    listen: IpAddr,
    /// What other machines and pages from elsewhere have to say first [default: random, where it is needed]
    #[arg(long, value_name = "TOKEN")]
    token: Option<String>,
    /// Serial port of a board that plays the scene; `sonoglyph ports` lists them
    #[arg(long, requires = "profile")]
    port: Option<PathBuf>,
    /// Kind of board; `sonoglyph ports` lists them
    #[arg(long, value_parser = parse_profile, requires = "port")]
    profile: Option<Profile>,
    /// Bits per second, instead of the board's default
    #[arg(long, requires = "port", value_parser = clap::value_parser!(u32).range(1200..=12_000_000))]
    baud: Option<u32>,
    /// CSV with the columns element, offset (degrees), gain (0 to 1), off (0 or 1), a row for every element
    #[arg(long, value_name = "FILE.csv", requires = "port")]
    calibration: Option<PathBuf>,
}

pub fn run(args: &ServeArgs) -> anyhow::Result<()> {
    let scene = match &args.scene {
        Some(path) => read_scene(path, None, &mut Files::new())?,
        None => Scene::default(),
    };
    let interrupted = interrupt::watch()?;
    let board = board(args, &scene, &interrupted)?;
    if interrupted.is_set() {
        return Ok(());
    }
    let plays = board.is_some();
    let desk = Arc::new(Desk::new(Arc::new(scene), Box::new(|| {})));
    let server = Server::start(settings(args), Arc::clone(&desk))?;
    let mut live = Live::new(Arc::clone(&desk), board)?;
    for line in server.addresses().lines() {
        say!("{line}")?;
    }
    if let Some(token) = server.token() {
        say!("token {token}")?;
    }
    if !args.listen.is_loopback() {
        note("what is sent over the network is not encrypted: who listens there reads the token, too");
    }
    note(if plays {
        "the board is silent until a program says send"
    } else {
        "no board: give --port and --profile"
    });
    while !interrupted.is_set() {
        live.turn();
    }
    drop(server);
    say!("{}", desk.counts.tally())?;
    let Some(health) = live.close() else { return Ok(()) };
    match health.state {
        State::Lost(why) => anyhow::bail!("{why}: the board was lost, and what it plays is not known"),
        State::Connecting | State::Ready if !health.silenced => {
            anyhow::bail!("the board could not be silenced: its port takes no bytes")
        }
        State::Connecting | State::Ready => Ok(()),
    }
}

fn settings(args: &ServeArgs) -> Settings {
    let ServeArgs { osc, websocket, ultraino, listen, .. } = *args;
    let usual = Settings { listen, token: args.token.clone(), ..Settings::default() };
    match (osc, websocket, ultraino) {
        (None, None, None) => usual,
        (Some(_), _, _) | (_, Some(_), _) | (_, _, Some(_)) => Settings { osc, websocket, ultraino, ..usual },
    }
}

/// The board at the port that is given, once it is there.
#[cfg(feature = "serial")]
fn board(args: &ServeArgs, scene: &Scene, interrupted: &Interrupted) -> anyhow::Result<Option<Board>> {
    use anyhow::Context;

    use crate::cli::boards::calibration;
    use crate::device::link;

    let (Some(port), Some(profile)) = (args.port.clone(), args.profile) else { return Ok(None) };
    let name = args.scene.as_ref().map_or_else(|| "the scene".to_owned(), |path| path.display().to_string());
    profile.drives(scene).context(name)?;
    let calibration = calibration(args.calibration.as_deref(), profile)?;
    let settings = link::Settings { port, profile, baud: args.baud };
    Board::open(settings, calibration, || interrupted.is_set())
}

#[cfg(not(feature = "serial"))]
fn board(args: &ServeArgs, _: &Scene, _: &Interrupted) -> anyhow::Result<Option<Board>> {
    match args.port {
        Some(_) => anyhow::bail!(
            "this program was built without serial links; `cargo build --features serial` has them"
        ),
        None => Ok(None),
    }
}
