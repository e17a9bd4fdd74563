//! Version 1 of the protocol, of which devices still answer INFO, so that an old program can report the version.

use crc::{CRC_16_GENIBUS, Crc};

use crate::device::native::line::Spoiled;
use crate::device::native::reply::{Flags, Info, less_one};
use crate::device::native::table::{Kind, Outcome, REPLY};

const CHECKSUM: Crc<u16> = Crc::<u16>::new(&CRC_16_GENIBUS);
/// The flags known to version 1.
const FLAGS: u8 = 0x3F;

/// INFO of version 1, with the delimiter at its end.
pub fn info(seq: u8) -> Vec<u8> {
    framed(vec![Kind::Info.code(), seq, 0, 0, 0, 0])
}

/// The sequence number, if this is version 1's INFO.
///
/// # Errors
/// It is not.
pub fn asked(bytes: &[u8]) -> Result<u8, Spoiled> {
    match checked(bytes)?[..] {
        [code, seq, _, _, _, _] if code == Kind::Info.code() => Ok(seq),
        _ => Err(Spoiled),
    }
}

/// A device's answer to version 1's INFO; its result is UNKNOWN.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Introduction {
    pub seq: u8,
    pub flags: Flags,
    pub info: Info,
}

impl Introduction {
    /// The bytes on the line, including the final delimiter.
    pub fn to_line(&self) -> Vec<u8> {
        let (info, flags) = (self.info, self.flags.bits() & FLAGS);
        let mut body = vec![Kind::Info.code() + REPLY, self.seq, Outcome::Unknown.code(), flags];
        body.extend([info.protocol, info.phase_bits, less_one(info.slots), info.version]);
        body.extend(info.carrier_millihertz.to_le_bytes());
        body.extend([less_one(info.channels), info.largest_baud]);
        framed(body)
    }
}

fn framed(mut body: Vec<u8>) -> Vec<u8> {
    body.extend(CHECKSUM.checksum(&body).to_be_bytes());
    let mut line = cobs::encode_vec(&body);
    line.push(0);
    line
}

fn checked(bytes: &[u8]) -> Result<Vec<u8>, Spoiled> {
    let mut body = cobs::decode_vec(bytes).map_err(|_| Spoiled)?;
    let Some((rest, &check)) = body.split_last_chunk() else { return Err(Spoiled) };
    if CHECKSUM.checksum(rest) != u16::from_be_bytes(check) {
        return Err(Spoiled);
    }
    body.truncate(body.len() - check.len());
    Ok(body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::native::packet::Packet;

    #[test]
    fn only_info_of_version_1_is_recognised() {
        let line = info(77);
        assert_eq!(line.len(), 10);
        assert_eq!(asked(line.strip_suffix(&[0]).unwrap()), Ok(77));
        for other in [framed(vec![2, 77, 0, 0, 0, 0]), framed(vec![1, 77, 0, 0, 0]), Packet::info().to_line()]
        {
            assert_eq!(asked(other.strip_suffix(&[0]).unwrap()), Err(Spoiled));
        }
        assert_eq!(asked(&[]), Err(Spoiled));
    }
}
