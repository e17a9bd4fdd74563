//! Encodes numbers as NPY files for `numpy.load`.

use std::fmt;
use std::io::{self, Write};

use npyz::WriterBuilder;

/// An NPY file of float32 in C order.
///
/// # Errors
/// The shape and the number of values differ.
pub fn npy(shape: &[u64], values: &[f32]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut numbers = Numbers::new(&mut bytes, shape)?;
    numbers.add(values)?;
    numbers.finish()?;
    Ok(bytes)
}

/// An NPY file of float32, written piece by piece.
pub struct Numbers<W: Write>(npyz::NpyWriter<f32, W>);

impl<W: Write> Numbers<W> {
    /// # Errors
    /// A file error.
    pub fn new(file: W, shape: &[u64]) -> io::Result<Self> {
        Ok(Self(npyz::WriteOptions::new().default_dtype().shape(shape).writer(file).begin_nd()?))
    }

    /// # Errors
    /// A file error.
    pub fn add(&mut self, values: &[f32]) -> io::Result<()> {
        self.0.extend(values.iter().copied())
    }

    /// # Errors
    /// The shape and the number of written values differ.
    pub fn finish(self) -> io::Result<()> {
        self.0.finish()
    }
}

impl<W: Write> fmt::Debug for Numbers<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Numbers").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::npy::read;

    #[test]
    fn an_array_is_read_as_it_was_written() {
        let bytes = npy(&[2, 3], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.5]).unwrap();
        assert_eq!(read(&bytes).unwrap(), (vec![2, 3], vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.5]));
        assert!(read(&bytes[..40]).is_err() && read(b"x,y\n1,2\n").is_err());
    }

    #[test]
    fn an_npy_is_little_endian_float32_in_c_order() {
        let bytes = npy(&[2, 3], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
        assert_eq!(&bytes[..6], b"\x93NUMPY");
        let header = String::from_utf8_lossy(&bytes[10..bytes.len() - 24]).into_owned();
        for part in ["'descr': '<f4'", "'fortran_order': False", "'shape': (2, 3"] {
            assert!(header.contains(part), "{header}");
        }
        assert_eq!(&bytes[bytes.len() - 4..], 6.0f32.to_le_bytes());
    }
}
