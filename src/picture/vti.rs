//! Writes volumes as VTK ImageData (`.vti`), XML with appended raw bytes, for ParaView, PyVista and 3D Slicer.

use std::fmt;
use std::io::{self, Write};

use glam::{DVec3, UVec3};

/// A volume of float32, written layer by layer, x fastest, then y, then z.
pub struct ImageData<W: Write> {
    file: W,
    /// Number of missing values.
    missing: u64,
}

impl<W: Write> ImageData<W> {
    /// For values at points: the first at `origin` (m), neighbours `spacing` (m) apart. The name must not need
    /// escapes.
    ///
    /// # Errors
    /// A file error.
    pub fn new(mut file: W, name: &str, origin: DVec3, spacing: DVec3, counts: UVec3) -> io::Result<Self> {
        let last = counts - UVec3::ONE;
        let extent = format!("0 {} 0 {} 0 {}", last.x, last.y, last.z);
        let missing = counts.as_u64vec3().element_product();
        let three = |v: DVec3| format!("{} {} {}", v.x, v.y, v.z);
        write!(
            file,
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
             <ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\">\n\
             <Piece Extent=\"{extent}\">\n\
             <PointData Scalars=\"{name}\">\n\
             <DataArray type=\"Float32\" Name=\"{name}\" format=\"appended\" offset=\"0\"/>\n\
             </PointData>\n\
             </Piece>\n\
             </ImageData>\n\
             <AppendedData encoding=\"raw\">\n_",
            three(origin),
            three(spacing),
        )?;
        file.write_all(&(missing * size_of::<f32>() as u64).to_le_bytes())?;
        Ok(Self { file, missing })
    }

    /// # Errors
    /// A file error, or more values than points.
    pub fn add(&mut self, values: &[f32]) -> io::Result<()> {
        self.missing = self
            .missing
            .checked_sub(values.len() as u64)
            .ok_or_else(|| io::Error::other("more values than points"))?;
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.file.write_all(&bytes)
    }

    /// # Errors
    /// A file error, or fewer values than points.
    pub fn finish(mut self) -> io::Result<()> {
        if self.missing > 0 {
            return Err(io::Error::other("fewer values than points"));
        }
        self.file.write_all(b"\n</AppendedData>\n</VTKFile>\n")
    }
}

impl<W: Write> fmt::Debug for ImageData<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ImageData").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    #[test]
    fn the_bytes_stand_behind_their_number_and_a_wrong_number_is_an_error() {
        let counts = UVec3::new(2, 1, 2);
        let mut bytes = Vec::new();
        let mut file =
            ImageData::new(&mut bytes, "rms", DVec3::ZERO, dvec3(1e-3, 2e-3, 0.5), counts).unwrap();
        file.add(&[1.0, 2.0]).unwrap();
        file.add(&[3.0, 4.0]).unwrap();
        file.finish().unwrap();
        let start = bytes.windows(2).position(|pair| pair == b"\n_").unwrap() + 2;
        let head = std::str::from_utf8(&bytes[..start]).unwrap();
        assert!(
            head.contains("WholeExtent=\"0 1 0 0 0 1\" Origin=\"0 0 0\" Spacing=\"0.001 0.002 0.5\""),
            "{head}"
        );
        assert_eq!(bytes[start..start + 8], 16u64.to_le_bytes());
        assert_eq!(bytes[start + 20..start + 24], 4.0f32.to_le_bytes());
        let mut sink = ImageData::new(io::sink(), "rms", DVec3::ZERO, DVec3::ONE, counts).unwrap();
        assert!(sink.add(&[0.0; 5]).is_err());
        assert!(
            ImageData::new(io::sink(), "rms", DVec3::ZERO, DVec3::ONE, counts).unwrap().finish().is_err()
        );
    }
}
