//! The server: sockets for other programs.

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, UdpSocket};
use std::sync::Arc;
use std::thread::JoinHandle;

use thiserror::Error;

use crate::control::desk::Desk;
use crate::control::gate::Gate;
use crate::control::{udp, websocket};

/// Default ports.
pub const OSC_PORT: u16 = 9000;
pub const WEBSOCKET_PORT: u16 = 9001;

/// Addresses and protocols to listen to; port 0 is any free port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    pub listen: IpAddr,
    pub osc: Option<u16>,
    pub websocket: Option<u16>,
    pub ultraino: Option<u16>,
    pub token: Option<String>,
}

impl Default for Settings {
    /// OSC and WebSocket, on this machine only.
    fn default() -> Self {
        let listen = Ipv4Addr::LOCALHOST.into();
        Self { listen, osc: Some(OSC_PORT), websocket: Some(WEBSOCKET_PORT), ultraino: None, token: None }
    }
}

#[derive(Debug, Error)]
pub enum ServerError {
    #[error("{what} on {address}: {error}; port 0 takes a free one")]
    Address { what: &'static str, address: SocketAddr, error: io::Error },
    #[error(transparent)]
    Gate(io::Error),
    #[error(transparent)]
    Thread(#[from] io::Error),
}

/// The addresses in use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Addresses {
    pub osc: Option<SocketAddr>,
    pub websocket: Option<SocketAddr>,
    pub ultraino: Option<SocketAddr>,
}

impl Addresses {
    /// A line for each.
    pub fn lines(&self) -> Vec<String> {
        let Self { osc, websocket, ultraino } = self;
        let osc = osc.map(|address| format!("OSC on udp://{address}"));
        let websocket = websocket.map(|address| format!("WebSocket on ws://{address}"));
        let ultraino = ultraino.map(|address| format!("Ultraino's words on udp://{address}"));
        [osc, websocket, ultraino].into_iter().flatten().collect()
    }
}

/// Listens until dropped, which closes its desk.
#[derive(Debug)]
pub struct Server {
    desk: Arc<Desk>,
    gate: Arc<Gate>,
    addresses: Addresses,
    threads: Vec<JoinHandle<()>>,
}

impl Server {
    /// # Errors
    /// An address that is taken or foreign, a token that is too weak, or a system without threads.
    pub fn start(settings: Settings, desk: Arc<Desk>) -> Result<Self, ServerError> {
        let Settings { listen, osc, websocket, ultraino, token } = settings;
        let gate = Arc::new(Gate::new(listen, token).map_err(ServerError::Gate)?);
        let at = |what, port: Option<u16>| port.map(|port| (what, SocketAddr::new(listen, port)));
        // All sockets are bound before any is served.
        let osc = at("OSC", osc).map(bound).transpose()?;
        let ultraino = at("Ultraino's words", ultraino).map(bound).transpose()?;
        let websocket = at("WebSocket", websocket).map(|(what, address)| {
            TcpListener::bind(address).map_err(|error| ServerError::Address { what, address, error })
        });
        let websocket = websocket.transpose()?;
        let addresses = Addresses {
            osc: osc.as_ref().map(UdpSocket::local_addr).transpose()?,
            websocket: websocket.as_ref().map(TcpListener::local_addr).transpose()?,
            ultraino: ultraino.as_ref().map(UdpSocket::local_addr).transpose()?,
        };
        let mut server =
            Self { desk: Arc::clone(&desk), gate: Arc::clone(&gate), addresses, threads: Vec::new() };
        if let Some(socket) = osc {
            server.threads.push(udp::osc(socket, Arc::clone(&desk), Arc::clone(&gate))?);
        }
        if let Some(socket) = ultraino {
            server.threads.push(udp::ultraino(socket, Arc::clone(&desk), Arc::clone(&gate))?);
        }
        if let Some(listener) = websocket {
            server.threads.push(websocket::listen(listener, desk, gate)?);
        }
        Ok(server)
    }

    pub fn addresses(&self) -> Addresses {
        self.addresses
    }

    /// The token for other clients.
    pub fn token(&self) -> Option<&str> {
        self.gate.token()
    }

    pub fn desk(&self) -> &Arc<Desk> {
        &self.desk
    }
}

fn bound((what, address): (&'static str, SocketAddr)) -> Result<UdpSocket, ServerError> {
    UdpSocket::bind(address).map_err(|error| ServerError::Address { what, address, error })
}

impl Drop for Server {
    fn drop(&mut self) {
        self.desk.close();
        for thread in self.threads.drain(..) {
            // A panic has already been reported.
            let _ = thread.join();
        }
    }
}
