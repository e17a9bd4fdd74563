//! Extremes in square windows, by which paper is told from ink. Beyond the border the outermost values continue.

/// The plane with its border repeated `margin` times on each side, and the length of its rows.
fn padded(values: &[f32], width: usize, margin: usize) -> (Vec<f32>, usize) {
    let height = values.len() / width;
    let stride = width + 2 * margin;
    let inside = |place: usize| place.saturating_sub(margin).min(height - 1);
    let mut plane = Vec::with_capacity(stride * (height + 2 * margin));
    for row in 0..height + 2 * margin {
        let row = &values[inside(row) * width..][..width];
        plane.extend(std::iter::repeat_n(row[0], margin));
        plane.extend(row);
        plane.extend(std::iter::repeat_n(row[width - 1], margin));
    }
    (plane, stride)
}

/// Extremes of each value and `length` - 1 values that follow at a step, by doubling.
fn following(mut values: Vec<f32>, step: usize, length: usize, pick: impl Fn(f32, f32) -> f32) -> Vec<f32> {
    let mut covered = 1;
    while covered < length {
        let more = covered.min(length - covered);
        values = values.iter().zip(&values[more * step..]).map(|(a, b)| pick(*a, *b)).collect();
        covered += more;
    }
    values
}

/// Extremes of the square whose first value stands in each value's place.
fn squares(values: Vec<f32>, stride: usize, side: usize, pick: impl Fn(f32, f32) -> f32) -> Vec<f32> {
    following(following(values, 1, side, &pick), stride, side, &pick)
}

fn cropped(plane: &[f32], stride: usize, width: usize, height: usize) -> Vec<f32> {
    (0..height).flat_map(|row| plane[row * stride..][..width].iter().copied()).collect()
}

/// Largest and smallest values within `radius` of each, diagonally too; row by row.
pub fn extremes(values: &[f32], width: usize, radius: usize) -> [Vec<f32>; 2] {
    let (plane, stride) = padded(values, width, radius);
    let crop = |plane: Vec<f32>| cropped(&plane, stride, width, values.len() / width);
    let largest = squares(plane.clone(), stride, 2 * radius + 1, f32::max);
    [crop(largest), crop(squares(plane, stride, 2 * radius + 1, f32::min))]
}

/// The closing by a square of 2 `radius` + 1 (Serra 1982): it fills valleys narrower than the square, and leaves
/// slopes and steps of any height, such as shadows and the edges of a sheet.
pub fn closed(values: &[f32], width: usize, radius: usize) -> Vec<f32> {
    let (plane, stride) = padded(values, width, 2 * radius);
    let side = 2 * radius + 1;
    // Squares begin at their own place: two of them have moved everything by the margin.
    let closed = squares(squares(plane, stride, side, f32::max), stride, side, f32::min);
    cropped(&closed, stride, width, values.len() / width)
}

/// The opening by a square of 2 `radius` + 1, which levels peaks narrower than the square.
pub fn opened(values: &[f32], width: usize, radius: usize) -> Vec<f32> {
    let (plane, stride) = padded(values, width, 2 * radius);
    let side = 2 * radius + 1;
    let opened = squares(squares(plane, stride, side, f32::min), stride, side, f32::max);
    cropped(&opened, stride, width, values.len() / width)
}
