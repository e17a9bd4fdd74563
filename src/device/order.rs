//! The channel order of boards: the element of each channel.

use crate::device::profile::Profile;

/// Of the eight channels of a shift register of a SonicSurface: column and row within their 4 x 2 elements.
const SONICSURFACE_COLUMNS: [usize; 8] = [0, 2, 3, 1, 0, 3, 2, 1];
const SONICSURFACE_ROWS: [usize; 8] = [0, 0, 0, 1, 1, 1, 1, 0];
/// Channel of the four columns of an acoustophoretic board's chip, in even and odd rows of the array.
const ACOUSTOPHORETIC_EVEN: [usize; 4] = [5, 4, 6, 7];
const ACOUSTOPHORETIC_ODD: [usize; 4] = [1, 0, 3, 2];

/// The element of a `channel`.
pub fn element_of(profile: Profile, channel: usize) -> usize {
    match profile {
        Profile::Native | Profile::Natives(_) | Profile::UltrainoSimpleFpga | Profile::UltrainoMega64 => {
            channel
        }
        Profile::SonicSurface | Profile::SonicSurface2 | Profile::SonicSurfaceTactile => {
            channel / 256 * 256 + sonicsurface(channel % 256)
        }
        // Rows and columns are few: the inverse is searched.
        Profile::Acoustophoretic512 => {
            (0..256).find(|&element| acoustophoretic(element) == channel).unwrap_or(channel)
        }
    }
}

/// Elements by channel; a bijection.
pub fn elements(profile: Profile) -> Vec<usize> {
    (0..profile.elements()).map(|channel| element_of(profile, channel)).collect()
}

/// The board counts its rows from its +z, which is this program's -y when both radiate to the front and x runs to the
/// right; so its grid has the array's numbering.
fn sonicsurface(channel: usize) -> usize {
    let column = 4 * (channel / 64) + SONICSURFACE_COLUMNS[channel % 8];
    let row = 2 * (channel % 64 / 8) + SONICSURFACE_ROWS[channel % 8];
    16 * row + column
}

/// The channel of an element. OpenMPD's pattern files list rows from the upper edge seen from the front, with y
/// upwards.
fn acoustophoretic(element: usize) -> usize {
    let (row, column) = (element / 16, element % 16);
    let places = if row % 2 == 0 { ACOUSTOPHORETIC_EVEN } else { ACOUSTOPHORETIC_ODD };
    64 * (3 - column / 4) + 8 * (row / 2) + places[column % 4]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_element_has_one_channel() {
        for profile in Profile::ALL {
            let mut elements = elements(profile);
            elements.sort_unstable();
            assert!(elements.into_iter().eq(0..profile.elements()), "{}", profile.name());
        }
    }

    #[test]
    fn known_channels_stand_where_they_do_on_the_boards() {
        let sonic = |channel| element_of(Profile::SonicSurface, channel);
        // The first register: columns 0, 2, 3, 1, 0, 3, 2, 1 of rows 0, 0, 0, 1, 1, 1, 1, 0.
        assert_eq!([0, 1, 2, 3, 4, 5, 6, 7].map(sonic), [0, 2, 3, 17, 16, 19, 18, 1]);
        assert_eq!((sonic(8), sonic(64), sonic(255)), (32, 4, 16 * 14 + 13));
        assert_eq!(element_of(Profile::SonicSurface2, 256), 256);
        // The upper left corner of the acoustophoretic board, and the row below it.
        assert_eq!([240, 241, 242, 243].map(acoustophoretic), [249, 248, 251, 250]);
        assert_eq!([224, 225, 226, 227].map(acoustophoretic), [253, 252, 254, 255]);
        assert_eq!(acoustophoretic(15), 7);
        assert_eq!(element_of(Profile::Acoustophoretic512, 249), 240);
    }
}
