//! Reads input files: regular files up to a size limit. Pipes and devices are refused without blocking. In a browser
//! the files are on the page's shelf.

#[cfg(not(target_arch = "wasm32"))]
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Files opened by the program's caller, which may be pipes.
#[cfg(not(target_arch = "wasm32"))]
const HANDED_OVER: [&str; 3] = ["/dev/stdin", "/dev/fd", "/proc/self/fd"];

/// Opens a regular file, or a pipe that the caller has handed over (`/dev/stdin`, `<(…)` of a shell).
///
/// # Errors
/// A system error; a folder, a device, or a pipe without a writer.
#[cfg(not(target_arch = "wasm32"))]
pub fn open(path: &Path) -> io::Result<File> {
    open_any(path).map_err(|error| match error.kind() {
        ErrorKind::NotFound => io::Error::new(ErrorKind::NotFound, "no such file"),
        _ => error,
    })
}

#[cfg(not(target_arch = "wasm32"))]
fn open_any(path: &Path) -> io::Result<File> {
    if HANDED_OVER.iter().any(|own| path.starts_with(own)) {
        let file = File::open(path)?;
        return if is_terminal_or_pipe(&file)? { Ok(file) } else { regular(file) };
    }
    regular(open_at_once(path)?)
}

/// Opens a file of the page.
///
/// # Errors
/// There is none.
#[cfg(target_arch = "wasm32")]
pub fn open(path: &Path) -> io::Result<io::Cursor<Vec<u8>>> {
    crate::shelf::read(path).map(io::Cursor::new)
}

/// Whether there is a file, or a folder.
pub fn exists(path: &Path) -> bool {
    #[cfg(target_arch = "wasm32")]
    return crate::shelf::has(path);
    #[cfg(not(target_arch = "wasm32"))]
    path.exists()
}

/// Removes a file, if possible.
pub fn remove(path: &Path) {
    #[cfg(target_arch = "wasm32")]
    crate::shelf::remove(path);
    #[cfg(not(target_arch = "wasm32"))]
    let _ = std::fs::remove_file(path);
}

/// The content of a file, up to `most` bytes.
///
/// # Errors
/// The errors of [`open`], and a file that has more.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(io::Error::new(
            ErrorKind::FileTooLarge,
            format!("larger than the {} MiB that are read", most >> 20),
        ));
    }
    Ok(bytes)
}

/// The text that [`read`] finds.
///
/// # Errors
/// The errors of [`read`], and bytes that are no UTF-8.
pub fn read_text(path: &Path, most: u64) -> io::Result<String> {
    let no_text = |_| io::Error::new(ErrorKind::InvalidData, "this is not a text file (UTF-8)");
    String::from_utf8(read(path, most)?).map_err(no_text)
}

#[cfg(not(target_arch = "wasm32"))]
fn regular(file: File) -> io::Result<File> {
    let there = file.metadata()?;
    if there.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    if !there.is_file() {
        return Err(io::Error::other("this is a device or a pipe, not a file"));
    }
    Ok(file)
}

/// Opens without waiting for the other end of a pipe.
#[cfg(unix)]
fn open_at_once(path: &Path) -> io::Result<File> {
    use rustix::fs::{Mode, OFlags};
    let how = OFlags::RDONLY | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    Ok(rustix::fs::open(path, how, Mode::empty())?.into())
}

#[cfg(all(not(unix), not(target_arch = "wasm32")))]
fn open_at_once(path: &Path) -> io::Result<File> {
    File::open(path)
}

#[cfg(unix)]
fn is_terminal_or_pipe(file: &File) -> io::Result<bool> {
    use std::io::IsTerminal;
    use std::os::unix::fs::FileTypeExt;
    Ok(file.is_terminal() || file.metadata()?.file_type().is_fifo())
}

#[cfg(all(not(unix), not(target_arch = "wasm32")))]
fn is_terminal_or_pipe(_: &File) -> io::Result<bool> {
    Ok(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read_up_to_their_bound() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(read_text(&path, 5).unwrap(), "12345");
        assert_eq!(read(&path, 4).unwrap_err().kind(), ErrorKind::FileTooLarge);
        assert_eq!(read(folder.path(), 4).unwrap_err().kind(), ErrorKind::IsADirectory);
        let missing = read(&folder.path().join("b"), 4).unwrap_err();
        assert_eq!((missing.kind(), missing.to_string()), (ErrorKind::NotFound, "no such file".to_owned()));
        std::fs::write(&path, [0xff]).unwrap();
        assert!(read_text(&path, 5).unwrap_err().to_string().contains("no UTF-8"));
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_pipes_are_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [&pipe, Path::new("/dev/zero"), Path::new("/dev/null")] {
            let error = read(path, 1 << 20).unwrap_err();
            assert!(error.to_string().contains("a device or a pipe"), "{}: {error}", path.display());
        }
    }
}
