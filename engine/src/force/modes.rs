//! Principal stiffnesses and their directions.

use glam::{DMat3, DVec3};

/// An eigenvector of a stiffness, with its eigenvalue.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mode {
    /// N/m; below 0 the bead is pushed away.
    pub stiffness: f64,
    /// A unit vector.
    pub direction: DVec3,
}

/// Modes of a symmetric matrix, the weakest first: Jacobi's rotations.
pub fn modes(matrix: &DMat3) -> [Mode; 3] {
    let mut a = matrix.to_cols_array_2d();
    let mut vectors = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
            let c = 1.0 / t.hypot(1.0);
            let s = t * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            let (above, below) = (a[p], a[q]);
            a[p] = [0, 1, 2].map(|k: usize| c * above[k] - s * below[k]);
            a[q] = [0, 1, 2].map(|k: usize| s * above[k] + c * below[k]);
            for row in &mut vectors {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
        }
    }
    let mut modes = [0, 1, 2].map(|i| Mode {
        stiffness: a[i][i],
        direction: DVec3::from_array([0, 1, 2].map(|row: usize| vectors[row][i])),
    });
    modes.sort_by(|a, b| a.stiffness.total_cmp(&b.stiffness));
    modes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_are_those_of_the_matrix() {
        let axes = DMat3::from_quat(glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0));
        for values in [[-2.0, 1.0, 5.0], [3.0, 3.0, 4.0], [0.0, 0.0, 1e-9]] {
            let matrix = axes * DMat3::from_diagonal(DVec3::from_array(values)) * axes.transpose();
            for (mode, value) in modes(&matrix).into_iter().zip(values) {
                assert!((mode.stiffness - value).abs() < 1e-14 * 5.0, "{mode:?}, not {value}");
                let off = matrix * mode.direction - mode.direction * value;
                assert!(off.length() < 1e-13 && (mode.direction.length() - 1.0).abs() < 1e-14, "{mode:?}");
            }
        }
    }
}
