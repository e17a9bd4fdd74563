//! Access control: programs of this machine, and others with the token.
//!
//! Any web page in a local browser can reach loopback. Its browser sends the page's `Origin`, and pages from
//! elsewhere need the token: a foreign page must not drive the array.

use std::collections::VecDeque;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::Mutex;

use tungstenite::http::Uri;

use crate::device::task::locked;

/// Limit of remembered UDP senders; beyond it, the longest silent ones must repeat the token.
const MOST_SENDERS: usize = 64;
/// Letters of a token.
const LENGTHS: std::ops::RangeInclusive<usize> = 8..=128;
/// Bytes of a random one.
const RANDOM: usize = 16;

#[derive(Debug)]
pub struct Gate {
    token: Option<String>,
    /// Whether only programs of this machine can reach the server.
    is_local: bool,
    senders: Mutex<VecDeque<SocketAddr>>,
}

impl Gate {
    /// The gate of a server at this address. If other machines can reach it, there is a token, by default a random one.
    ///
    /// # Errors
    /// A token that could be guessed or cannot be written in an address, and a system without random numbers.
    pub fn new(listen: IpAddr, token: Option<String>) -> io::Result<Self> {
        let is_local = listen.is_loopback();
        let is_letter = |c: char| c.is_ascii_alphanumeric() || "-_.~".contains(c);
        let token = match token {
            Some(token) if LENGTHS.contains(&token.len()) && token.chars().all(is_letter) => Some(token),
            Some(_) => {
                let (least, most) = (LENGTHS.start(), LENGTHS.end());
                let text = format!("the token must have {least} to {most} letters, digits, -, _, . or ~");
                return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
            }
            None if is_local => None,
            None => Some(random()?),
        };
        Ok(Self { token, is_local, senders: Mutex::default() })
    }

    pub fn token(&self) -> Option<&str> {
        self.token.as_deref()
    }

    /// Compares with the token, in constant time.
    pub fn fits(&self, token: &str) -> bool {
        let Some(own) = &self.token else { return false };
        let differ = own.bytes().zip(token.bytes()).fold(0, |differ, (a, b)| differ | (a ^ b));
        own.len() == token.len() && differ == 0
    }

    /// Whether a connection needs the token, given the origin of its page, if any.
    pub fn asks(&self, origin: Option<&str>) -> bool {
        !self.is_local || origin.is_some_and(|origin| !is_of_this_machine(origin))
    }

    /// Whether a UDP sender is admitted.
    pub fn knows(&self, sender: SocketAddr) -> bool {
        if self.is_local {
            return true;
        }
        let mut senders = locked(&self.senders);
        let Some(place) = senders.iter().position(|known| *known == sender) else { return false };
        // The most recent sender is last.
        senders.remove(place);
        senders.push_back(sender);
        true
    }

    /// Whether a host is admitted for protocols without a token: this machine, or the host of an admitted sender.
    pub fn knows_host(&self, host: IpAddr) -> bool {
        // A server at all addresses sees those of IPv4 as ::ffff:127.0.0.1.
        host.to_canonical().is_loopback() || locked(&self.senders).iter().any(|known| known.ip() == host)
    }

    /// Admits a sender with the token.
    pub fn admit(&self, sender: SocketAddr, token: &str) -> bool {
        let fits = self.fits(token);
        if fits && !self.knows(sender) {
            let mut senders = locked(&self.senders);
            if senders.len() >= MOST_SENDERS {
                senders.pop_front();
            }
            senders.push_back(sender);
        }
        fits
    }
}

/// Whether a page's server is on this machine. Pages from files have the origin `null`, but so can foreign frames.
fn is_of_this_machine(origin: &str) -> bool {
    let uri = origin.parse::<Uri>().unwrap_or_default();
    let (Some(_), Some(authority)) = (uri.scheme(), uri.authority()) else { return false };
    let is_port = |port: &str| port.parse::<u16>().is_ok();
    let is_alone = |rest: &str| rest.is_empty() || rest.strip_prefix(':').is_some_and(is_port);
    ["localhost", "127.0.0.1", "[::1]"].contains(&authority.host())
        && authority.as_str().strip_prefix(authority.host()).is_some_and(is_alone)
}

/// Hexadecimal, two letters per random byte.
fn random() -> io::Result<String> {
    let mut bytes = [0; RANDOM];
    getrandom::fill(&mut bytes).map_err(|error| io::Error::other(error.to_string()))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_pages_of_this_machine_need_no_token() {
        for own in [
            "http://localhost",
            "http://localhost:8000",
            "https://127.0.0.1:1",
            "http://[::1]",
            "http://[::1]:80",
        ] {
            assert!(is_of_this_machine(own), "{own}");
        }
        for other in [
            "null",
            "",
            "http://localhost.example.org",
            "http://127.0.0.1.example.org:80",
            "http://example.org/localhost",
            "http://localhost:80@example.org",
            "http://user@localhost",
            "http://[::1].example.org",
            "http://[::1]example.org:80",
            "http://[::2]",
            "http://x[::1]:80",
            "http://",
        ] {
            assert!(!is_of_this_machine(other), "{other}");
        }
    }

    #[test]
    fn senders_that_are_silent_for_longest_are_forgotten_first() {
        let gate = Gate::new([0, 0, 0, 0].into(), None).unwrap();
        let token = gate.token().unwrap().to_owned();
        assert_eq!(token.len(), 2 * RANDOM);
        let sender = |port: u16| SocketAddr::from(([192, 0, 2, 1], port));
        assert!(!gate.knows(sender(1)) && !gate.admit(sender(1), "guess") && !gate.knows(sender(1)));
        assert!(gate.admit(sender(1), &token) && gate.admit(sender(2), &token));
        for port in 3..=MOST_SENDERS as u16 + 1 {
            assert!(gate.knows(sender(1)) && gate.admit(sender(port), &token));
        }
        assert!(gate.knows(sender(1)) && !gate.knows(sender(2)) && gate.knows_host(sender(9).ip()));
        assert!(!gate.knows_host([192, 0, 2, 2].into()));
        for bad in ["short", "with space in it", "ümlaut-ümlaut"] {
            assert!(Gate::new([127, 0, 0, 1].into(), Some(bad.to_owned())).is_err(), "{bad}");
        }
    }

    #[test]
    fn many_packets_of_one_sender_displace_no_other() {
        let gate = Gate::new([0, 0, 0, 0].into(), Some("correct-horse".to_owned())).unwrap();
        let [first, busy, last] = [1, 2, 3].map(|port| SocketAddr::from(([192, 0, 2, 1], port)));
        assert!(gate.admit(first, "correct-horse") && gate.admit(busy, "correct-horse"));
        assert!((0..MOST_SENDERS).all(|_| gate.knows(busy)));
        assert!(gate.admit(last, "correct-horse"));
        assert!([first, busy, last].into_iter().all(|sender| gate.knows(sender)));
    }

    #[test]
    fn hosts_are_this_machine_and_those_of_admitted_senders() {
        let gate = Gate::new([0, 0, 0, 0].into(), Some("correct-horse".to_owned())).unwrap();
        let [one, other] = ["192.0.2.1:5000", "192.0.2.2:5000"].map(|sender| sender.parse().unwrap());
        assert!(gate.admit(one, "correct-horse") && gate.admit(other, "correct-horse"));
        let known = |host: &str| gate.knows_host(host.parse().unwrap());
        for host in ["127.0.0.1", "::1", "::ffff:127.0.0.1", "192.0.2.1", "192.0.2.2"] {
            assert!(known(host), "{host}");
        }
        assert!(!known("192.0.2.3") && !known("::ffff:192.0.2.3"));
    }

    #[test]
    fn a_token_with_one_other_letter_does_not_fit() {
        const TOKEN: &str = "correct-horse";
        let gate = Gate::new([127, 0, 0, 1].into(), Some(TOKEN.to_owned())).unwrap();
        assert!(gate.fits(TOKEN));
        for place in 0..TOKEN.len() {
            let mut other = TOKEN.to_owned();
            other.replace_range(place..=place, "_");
            assert!(!gate.fits(&other) && !gate.fits(&TOKEN[..place]), "{other}");
        }
        assert!(!gate.fits(&format!("{TOKEN}_")));
    }
}
