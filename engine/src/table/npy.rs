//! Arrays of NumPy (`.npy`) as tables.

use npyz::{NpyFile, Order};

use crate::echo;
use crate::table::records::Records;

pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// The shape and the values of an NPY file of numbers, in C order.
///
/// # Errors
/// Another file, or values that are no real numbers, as a message.
#[doc(hidden)]
pub fn read(bytes: &[u8]) -> Result<(Vec<usize>, Vec<f64>), String> {
    let file = || {
        NpyFile::new(bytes).map_err(|error| format!("a broken NPY file: {}", echo::value(&error.to_string())))
    };
    let (shape, order, kind) = {
        let file = file()?;
        (file.shape().iter().map(|&length| length as usize).collect::<Vec<_>>(), file.order(), file.dtype())
    };
    let values: Vec<f64> = if let Ok(values) = file()?.into_vec::<f64>() {
        values
    } else if let Ok(values) = file()?.into_vec::<f32>() {
        values.into_iter().map(f64::from).collect()
    } else if let Ok(values) = file()?.into_vec::<i64>() {
        values.into_iter().map(|value| value as f64).collect()
    } else if let Ok(values) = file()?.into_vec::<i32>() {
        values.into_iter().map(f64::from).collect()
    } else {
        let kind = echo::value(&kind.descr());
        return Err(format!("an NPY file of {kind}: must be of float64, float32 or integers"));
    };
    match order {
        Order::C => Ok((shape, values)),
        Order::Fortran => Ok((shape.clone(), in_c_order(&shape, &values))),
    }
}

fn in_c_order(shape: &[usize], values: &[f64]) -> Vec<f64> {
    let at = |index: usize| {
        let (mut rest, mut place, mut stride) = (index, 0, values.len());
        // The last axis runs fastest in C order, and is the farthest apart in the other.
        for &length in shape.iter().rev() {
            stride /= length.max(1);
            place += rest % length.max(1) * stride;
            rest /= length.max(1);
        }
        values[place]
    };
    (0..values.len()).map(at).collect()
}

/// The rows of an array of two axes.
///
/// # Errors
/// The errors of [`read`], or another number of axes, as a message.
pub(crate) fn table(bytes: &[u8]) -> Result<Records, String> {
    let (shape, values) = read(bytes)?;
    let [rows, columns] = shape[..] else {
        return Err(format!("an NPY array of shape {shape:?}: must be (elements, columns)"));
    };
    if rows * columns != values.len() || columns == 0 {
        return Err(format!("an NPY array of shape {shape:?} with {} values", values.len()));
    }
    let row = |row: &[f64]| (1, row.iter().map(|value| format!("{value:?}")).collect());
    Ok(Records { names: None, rows: values.chunks_exact(columns).map(row).collect(), separator: b',' })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An NPY file as NumPy writes it.
    fn file(kind: &str, is_fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let mut header =
            format!("{{'descr': '{kind}', 'fortran_order': {is_fortran}, 'shape': {shape}, }}").into_bytes();
        header.resize((header.len() + 10).div_ceil(64) * 64 - 11, b' ');
        header.push(b'\n');
        [MAGIC, &[1, 0], &(header.len() as u16).to_le_bytes(), &header, data].concat()
    }

    #[test]
    fn arrays_of_any_order_are_read_by_rows() {
        let little: Vec<_> = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0f64].iter().flat_map(|x| x.to_le_bytes()).collect();
        let big: Vec<_> = [1.0, 4.0, 2.0, 5.0, 3.0, 6.0f32].iter().flat_map(|x| x.to_be_bytes()).collect();
        let expected = Ok((vec![2, 3], vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
        assert_eq!(read(&file("<f8", "False", "(2, 3)", &little)), expected);
        assert_eq!(read(&file(">f4", "True", "(2, 3)", &big)), expected);
        assert!(read(&file("<c16", "False", "(3,)", &little)).unwrap_err().contains("must be of float64"));
        assert!(table(&file("<f8", "False", "(6,)", &little)).unwrap_err().contains("(elements, columns)"));
    }
}
