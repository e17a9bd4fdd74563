//! The framing of the native protocol: CRC, COBS, and delimiter.

use crc::{CRC_32_ISO_HDLC, Crc};

const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
/// Type, address, sequence number and four arguments.
const HEAD: usize = 7;
const CRC_BYTES: usize = 4;
/// The longest packet before COBS, CRC included: a frame with amplitudes.
pub const LONGEST: usize = HEAD + 512 + CRC_BYTES;
/// COBS puts one byte in front, one more after every 254.
const LONGEST_ON_LINE: usize = LONGEST + 1 + LONGEST / 254;
/// Why bytes between two delimiters are no packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spoiled;

/// CRC-32 of a table's bytes, as DIGEST answers it.
pub fn digest(table: &[u8]) -> u32 {
    CHECKSUM.checksum(table)
}

/// CRC, COBS and delimiter around a body.
pub fn framed(mut body: Vec<u8>) -> Vec<u8> {
    body.extend(CHECKSUM.checksum(&body).to_le_bytes());
    let mut line = cobs::encode_vec(&body);
    line.push(0);
    line
}

/// The body within COBS and CRC.
pub fn checked(bytes: &[u8]) -> Result<Vec<u8>, Spoiled> {
    if bytes.len() > LONGEST_ON_LINE {
        return Err(Spoiled);
    }
    let mut body = cobs::decode_vec(bytes).map_err(|_| Spoiled)?;
    let Some((rest, &check)) = body.split_last_chunk() else { return Err(Spoiled) };
    if body.len() > LONGEST || CHECKSUM.checksum(rest) != u32::from_le_bytes(check) {
        return Err(Spoiled);
    }
    body.truncate(body.len() - CRC_BYTES);
    Ok(body)
}

/// Cuts a stream of bytes at its delimiters.
#[derive(Clone, Debug, Default)]
pub struct Splitter {
    part: Vec<u8>,
}

impl Splitter {
    /// The bytes before the delimiter, if `byte` is one and there are any. Overlong packets are truncated and later
    /// refused.
    pub fn push(&mut self, byte: u8) -> Option<Vec<u8>> {
        if byte != 0 {
            if self.part.len() <= LONGEST_ON_LINE {
                self.part.push(byte);
            }
            return None;
        }
        let part = std::mem::take(&mut self.part);
        (!part.is_empty()).then_some(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_zlib() {
        // The catalogue's check value, and the register that body and CRC end at before the final XOR.
        assert_eq!(CHECKSUM.checksum(b"123456789"), 0xCBF4_3926);
        let mut line = b"123456789".to_vec();
        line.extend(0xCBF4_3926u32.to_le_bytes());
        assert_eq!(CHECKSUM.checksum(&line) ^ 0xFFFF_FFFF, 0xDEBB_20E3);
    }

    #[test]
    fn a_stream_is_cut_at_delimiters_and_never_kept_for_ever() {
        let mut splitter = Splitter::default();
        let parts: Vec<_> =
            [0, 0, 1, 2, 0, 0, 3, 0].into_iter().filter_map(|byte| splitter.push(byte)).collect();
        assert_eq!(parts, [vec![1, 2], vec![3]]);
        (0..100_000).for_each(|_| assert_eq!(splitter.push(9), None));
        assert!(splitter.push(0).unwrap().len() < 1000);
    }

    #[test]
    fn a_byte_after_the_longest_packet_spoils_it() {
        let line = framed(vec![7; LONGEST - CRC_BYTES]);
        let packet = line.strip_suffix(&[0]).unwrap();
        assert_eq!(packet.len(), LONGEST_ON_LINE);
        for more in [0, 1, 9] {
            let (mut splitter, bytes) = (Splitter::default(), [packet, &vec![9; more], &[0]].concat());
            let part = bytes.into_iter().find_map(|byte| splitter.push(byte)).unwrap();
            assert_eq!(checked(&part).is_ok(), more == 0, "{more} more");
        }
    }
}
