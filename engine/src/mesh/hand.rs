//! A hand as a smooth union of palm, muscles and fingers.
//!
//! It is a right hand: x runs along the fingers, z is the direction to which the palm faces, and y completes the
//! right-handed axes. Who looks at the palm with its fingers up sees y to the left, and the thumb to the right: at negative y.
//!
//! Lengths of fingers from their creases are means of 51 young adults (G. N. Chatzıoglou, Y. Pınar, F. Govsa, Anat. Cell
//! Biol. 57, 172, 2024), and phalanges those of A. Buryanov, V. Kotiuk (Int. J. Morphol. 28, 755, 2010), both relative to a
//! palm of 100 mm. The radii belong to a palm 85 mm wide and 25 mm thick: fingertips have 7.6 mm. A bend is shared by a
//! finger's joints as their ranges are.
//!
//! Parts are signed distances, united by a polynomial minimum (I. Quílez) that rounds the groove between two parts.

use glam::{DQuat, DVec2, DVec3, dvec2, dvec3};

use crate::mesh::closed::{Mesh, area_vector};
use crate::mesh::march;

/// Parts of a bend by which the three bones of a digit are turned, the base's first.
const TURNS: [f64; 3] = [0.35, 0.74, 1.0];
/// The palm of which the lengths below are parts, m.
const USUAL: DVec3 = dvec3(0.1, 0.085, 0.025);
/// Index, middle, ring and little finger: x of the crease, the length from there, y of the base (parts of half the
/// width), the angle to x (degrees), bones, and the radius relative to the middle finger's. All m.
const FINGERS: [Finger; 4] = [
    Finger { crease: 0.047, length: 0.0639, y: -0.725, angle: -7.0, bones: [0.0398, 0.0224], radius: 0.98 },
    Finger { crease: 0.050, length: 0.0707, y: -0.235, angle: -1.5, bones: [0.0446, 0.0263], radius: 1.0 },
    Finger { crease: 0.047, length: 0.0655, y: 0.255, angle: 4.0, bones: [0.0414, 0.0257], radius: 0.95 },
    Finger { crease: 0.039, length: 0.0533, y: 0.71, angle: 11.0, bones: [0.0327, 0.0181], radius: 0.84 },
];
/// Radii at the joints of the middle finger and of its tip, m.
const RADII: [f64; 4] = [0.0096, 0.0092, 0.0083, 0.0076];
/// Of the end bones with their soft tissue, m.
const ENDS: [f64; 4] = [0.0197, 0.0214, 0.0213, 0.0197];
/// Bones of the thumb, from the wrist, m.
const THUMB: [f64; 3] = [0.0462, 0.0316, 0.0274];
/// Radii at the joints of the thumb and of its tip, m.
const THUMB_RADII: [f64; 4] = [0.0125, 0.0118, 0.0105, 0.0084];
/// Widths of the rounded grooves, m: at joints, between fingers, and at the palm.
const JOINT: f64 = 0.0025;
const BETWEEN: f64 = 0.0016;
const PALM: f64 = 0.009;

struct Finger {
    crease: f64,
    length: f64,
    y: f64,
    angle: f64,
    bones: [f64; 2],
    radius: f64,
}

/// A digit: the joints and the centre of the ball in its tip (m), and the radii there.
#[derive(Clone, Copy, Debug)]
struct Digit {
    joints: [DVec3; 4],
    radii: [f64; 4],
}

/// A hand whose palm has a size (m).
struct Hand {
    size: DVec3,
    /// Of its radii and grooves, relative to the usual hand.
    scale: f64,
    digits: [Digit; 5],
    /// Height of the palm's skin above its slab's.
    skin: f64,
}

/// The surface of a hand whose palm has a size (m: along x, across, and its thickness), and whose digits are bent by angles
/// (degrees; thumb, index, middle, ring, little), with edges of about a length (m). The middle of the palm's skin is the origin.
pub(super) fn mesh(size: DVec3, bends: [f64; 5], edge: f64) -> Mesh {
    let hand = Hand::new(size, bends);
    let (low, high) = hand.extent();
    // Fine enough for the gaps between fingers; what is finer yet is divided.
    let side = (1.2 * edge).clamp((high - low).max_element() / 500.0, hand.scale * 0.003);
    let mesh = march::surface(|at| hand.distance(at), hand.steepest(), (low, high), side);
    hand.around(mesh.with_edges(edge).mapped(|at| hand.on_skin(at, 0.2 * edge)))
}

impl Hand {
    fn new(size: DVec3, bends: [f64; 5]) -> Self {
        let ratio = size / USUAL;
        let scale = ratio.y.min(ratio.z);
        let middle = -size.z / 2.0;
        let finger = |finger: &Finger, end: f64, bend: f64| {
            let bones = [finger.bones[0], finger.bones[1], end].map(|bone| bone * ratio.x);
            let radii = RADII.map(|radius| radius * finger.radius * scale);
            let forwards = DVec3::X.rotate_z(finger.angle.to_radians());
            let base = (finger.crease + finger.length) * ratio.x - bones.iter().sum::<f64>();
            let base = dvec3(base, finger.y * size.y / 2.0, middle);
            Digit::new(base, [forwards, DVec3::Z], bones, radii, bend)
        };
        let thumb = {
            // Away from the palm by 42°, raised by 14°, and bent towards the palm's middle line as much as upwards.
            let forwards = DQuat::from_rotation_z(-0.73) * DQuat::from_rotation_y(-0.25) * DVec3::X;
            let inwards = (dvec3(0.2, 0.7, 0.7)).reject_from(forwards).normalize_or(DVec3::Z);
            let base = dvec3(-0.37 * size.x, -0.22 * size.y, -0.42 * size.z);
            let bones = THUMB.map(|bone| bone * ratio.x);
            let radii = THUMB_RADII.map(|radius| radius * scale);
            Digit::new(base, [forwards, inwards], bones, radii, bends[0])
        };
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| finger(&FINGERS[i], ENDS[i], bends[i + 1]));
        let mut hand = Self { size, scale, digits: [thumb, a, b, c, d], skin: 0.0 };
        hand.skin = hand.height();
        hand
    }

    /// The height of the palm's skin in its middle, by halving.
    fn height(&self) -> f64 {
        let (mut below, mut above) = (-self.size.z / 2.0, self.size.z / 2.0);
        for _ in 0..50 {
            let middle = f64::midpoint(below, above);
            let half = if self.distance(DVec3::Z * middle) < 0.0 { &mut below } else { &mut above };
            *half = middle;
        }
        below
    }

    fn extent(&self) -> (DVec3, DVec3) {
        let (mut low, mut high) = (self.size * dvec3(-0.5, -0.5, -1.0), self.size * dvec3(0.5, 0.5, 0.0));
        for digit in &self.digits {
            for (joint, radius) in digit.joints.iter().zip(digit.radii) {
                (low, high) = (low.min(joint - radius), high.max(joint + radius));
            }
        }
        let margin = self.scale * 2.0 * PALM;
        (low - margin, high + margin)
    }

    /// The most by which [`Self::distance`] changes per length: a wall of the palm that runs at a slope is nearer.
    fn steepest(&self) -> f64 {
        let (end, wall) = (0.4 * self.size.x / self.size.y, 0.35 * self.size.y / self.size.x);
        (1.0 + end.max(wall).powi(2)).sqrt()
    }

    /// Distance from the skin (m), negative inside; between parts less than that.
    fn distance(&self, at: DVec3) -> f64 {
        let at = at + DVec3::Z * self.skin;
        let palm = self.palm(at);
        let (between, groove) = (self.scale * BETWEEN, self.scale * PALM);
        let near = self.digits.iter().filter(|digit| digit.nearest(at) < palm + groove + between);
        let digits = near.map(|digit| digit.distance(at, self.scale * JOINT));
        match digits.reduce(|all, digit| united(all, digit, between)) {
            Some(digits) => united(palm, digits, groove),
            None => palm,
        }
    }

    /// The palm without digits: a slab that narrows to the wrist, with the ball of the thumb and that of the little finger.
    fn palm(&self, at: DVec3) -> f64 {
        let size = self.size;
        let (along, across) = (at.x / (size.x / 2.0), at.y / (size.y / 2.0));
        // The creases of index and little finger are behind that of the middle finger.
        let end = 0.47 - 0.09 * step(0.2, 1.0, across) - 0.03 * step(0.2, 1.0, -across);
        let length = if at.x > 0.0 { end } else { 0.5 } * size.x;
        let width = size.y / 2.0 * (0.74 + 0.26 * step(-1.0, 0.4, along));
        let round = 0.22 * size.y;
        let beyond = dvec2(at.x.abs() - length, at.y.abs() - width) + round;
        let flat = beyond.max(DVec2::ZERO).length() + beyond.max_element().min(0.0) - round;
        let margin = 0.48 * size.z;
        let beyond = dvec2(flat + margin, (at.z + size.z / 2.0).abs() - size.z / 2.0 + margin);
        let slab = beyond.max(DVec2::ZERO).length() + beyond.max_element().min(0.0) - margin;
        let place = |x: f64, y: f64, z: f64| dvec3(x, y, z) * size;
        let thumb = self.digits[0].joints;
        let of_thumb = cone(at, [thumb[0], thumb[1]], [0.0145 * self.scale, 0.0115 * self.scale]);
        let ends = [place(-0.32, 0.21, -0.46), place(0.1, 0.3, -0.46)];
        let of_little = cone(at, ends, [0.0135 * self.scale, 0.012 * self.scale]);
        let groove = self.scale * PALM;
        united(united(slab, of_thumb, 1.3 * groove), of_little, groove)
    }

    /// The mesh with vertices moved off the skin until its triangles are as much inside as outside: with vertices on the skin
    /// those of round parts would be inside, and the hand too small.
    fn around(&self, mut mesh: Mesh) -> Mesh {
        let mut moves = vec![DVec3::ZERO; mesh.vertices.len()];
        let mut areas = vec![DVec3::ZERO; mesh.vertices.len()];
        for (triangle, vertices) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(triangle);
            let area = area_vector([a, b, c]);
            let middles = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
            let depth = -middles.map(|at| self.distance(at)).iter().sum::<f64>() / 3.0;
            for &vertex in vertices {
                moves[vertex as usize] += area * depth;
                areas[vertex as usize] += area;
            }
        }
        for ((at, moved), area) in mesh.vertices.iter_mut().zip(moves).zip(areas) {
            *at += moved / area.length().max(f64::MIN_POSITIVE);
        }
        mesh
    }

    /// A place on the skin near a point, at most a distance (m) away.
    fn on_skin(&self, mut at: DVec3, farthest: f64) -> DVec3 {
        let step = 1e-3 * self.scale * JOINT;
        for _ in 0..2 {
            let rise = |axis: DVec3| self.distance(at + axis * step) - self.distance(at - axis * step);
            let slope = dvec3(rise(DVec3::X), rise(DVec3::Y), rise(DVec3::Z)) / (2.0 * step);
            let away = slope * (self.distance(at) / slope.length_squared().max(0.1));
            at -= away.clamp_length_max(farthest / 2.0);
        }
        at
    }
}

impl Digit {
    /// Bones from a base, straight along the first direction and bent (degrees) to the second one; the last with its skin.
    fn new(
        base: DVec3,
        [forwards, inwards]: [DVec3; 2],
        bones: [f64; 3],
        radii: [f64; 4],
        bend: f64,
    ) -> Self {
        let mut joints = [base; 4];
        for i in 0..3 {
            let (sine, cosine) = (TURNS[i] * bend).to_radians().sin_cos();
            let bone = if i == 2 { bones[2] - radii[3] } else { bones[i] };
            joints[i + 1] = joints[i] + (forwards * cosine + inwards * sine) * bone;
        }
        Self { joints, radii }
    }

    /// The least that its distance can be.
    fn nearest(&self, at: DVec3) -> f64 {
        let [first, .., last] = self.joints;
        let middle = first.midpoint(last);
        // Joints are within half the length of the bones from there, and grooves are shallower than the radius.
        let bones: f64 = self.joints.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
        at.distance(middle) - bones / 2.0 - 2.0 * self.radii[0]
    }

    fn distance(&self, at: DVec3, groove: f64) -> f64 {
        let bone =
            |i: usize| cone(at, [self.joints[i], self.joints[i + 1]], [self.radii[i], self.radii[i + 1]]);
        united(united(bone(0), bone(1), groove), bone(2), groove)
    }
}

/// The distance from two balls and the cone around them.
fn cone(at: DVec3, [a, b]: [DVec3; 2], [one, other]: [f64; 2]) -> f64 {
    let along = b - a;
    let (length, less) = (along.length(), one - other);
    if length <= less.abs() {
        return (at.distance(a) - one).min(at.distance(b) - other);
    }
    let x = (at - a).dot(along) / length;
    let y = (at - a).reject_from(along).length();
    // The cone touches the balls where its normal does.
    let (sine, cosine) = (less / length, (1.0 - (less / length).powi(2)).sqrt());
    let foot = x - y * sine / cosine;
    match foot {
        ..0.0 => (x * x + y * y).sqrt() - one,
        _ if foot > length => ((x - length).powi(2) + y * y).sqrt() - other,
        _ => y * cosine + x * sine - one,
    }
}

/// The smaller distance, less near a groove of a width between two parts.
fn united(a: f64, b: f64, groove: f64) -> f64 {
    let near = (groove - (a - b).abs()).max(0.0);
    a.min(b) - near * near / (4.0 * groove)
}

/// From 0 to 1 between two numbers, without a bend.
fn step(from: f64, to: f64, x: f64) -> f64 {
    let part = ((x - from) / (to - from)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    const EDGE: f64 = 2.1e-3;

    #[test]
    fn a_hand_is_closed_and_has_a_hands_volume() {
        for (bends, edge) in [([0.0; 5], EDGE), ([30.0, 0.0, 90.0, 150.0, 250.0], EDGE), ([0.0; 5], 8e-3)] {
            let mesh = mesh(USUAL, bends, edge);
            let again = mesh.clone().closed().unwrap();
            assert_eq!(again.triangles.len(), mesh.triangles.len());
            assert!((again.volume() / mesh.volume() - 1.0).abs() < 1e-9, "turned over");
            // Of men 380 cm³ and women 290 cm³, with the wrist.
            assert!((250e-6..400e-6).contains(&mesh.volume()), "{bends:?}: {}", mesh.volume());
            assert!(mesh.longest_edge() < 1.6 * edge, "{}", mesh.longest_edge());
            let skin = mesh.vertices.iter().filter(|at| at.z > -0.01 && at.truncate().length() < 0.004);
            assert!(skin.clone().count() > 3 || edge > EDGE);
            assert!(skin.clone().all(|at| at.z.abs() < 4e-4), "{:?}", skin.collect::<Vec<_>>());
        }
    }

    #[test]
    fn fingertips_are_where_the_angles_say() {
        let tip = |digit: usize, bends: [f64; 5]| {
            let hand = Hand::new(USUAL, bends);
            let [.., last, ball] = hand.digits[digit].joints;
            let along = (ball - last).normalize_or_zero();
            (ball + along * hand.digits[digit].radii[3] - DVec3::Z * hand.skin, along)
        };
        let bends = [30.0, 10.0, 60.0, 90.0, 150.0];
        let mesh = mesh(USUAL, bends, EDGE);
        for digit in 0..5 {
            let (at, along) = tip(digit, bends);
            assert!(mesh.contains(at - along * 7e-4) && !mesh.contains(at + along * 7e-4), "{digit}");
            let (straight, _) = tip(digit, [0.0; 5]);
            assert!(at.z > straight.z + 0.005, "{digit} bends to where the palm faces");
        }
        let (straight, along) = tip(2, [0.0; 5]);
        assert!(
            (straight.x - (USUAL.x / 2.0 + 0.0707)).abs() < 1e-3,
            "the middle finger's length: {straight}"
        );
        assert!(along.x > 0.99);
        let (bent, along) = tip(2, [90.0; 5]);
        assert!(along.z > 0.999, "{along}");
        // Bones of 44.6, 26.3 and 21.4 mm at 31.5°, 66.6° and 90°.
        let expected = 0.0446 * (0.35 * FRAC_PI_2).cos() + 0.0263 * (0.74 * FRAC_PI_2).cos();
        let base = USUAL.x / 2.0 + 0.0707 - (0.0446 + 0.0263 + 0.0214);
        assert!((bent.x - (base + expected)).abs() < 1e-3, "{bent} {}", base + expected);
        assert!(tip(0, [0.0; 5]).0.y < -USUAL.y / 2.0, "the thumb of a right hand");
        assert!(tip(4, [0.0; 5]).0.y > 0.0 && tip(1, [0.0; 5]).0.y < 0.0);
    }
}
