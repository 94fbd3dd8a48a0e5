//! Files that are written whole or not at all.
//!
//! A [`WholeFile`] is written beside the place that it goes to and takes that place when it is [finished](WholeFile::finish). Where the disk is
//! full, or the program ends on the way, the file that was there before stays as it was.
//!
//! ```
//! use std::io::Write;
//!
//! let path = std::env::temp_dir().join(format!("signorini-files-{}", std::process::id()));
//! signorini_files::write(&path, b"old")?;
//! let mut file = signorini_files::WholeFile::create(&path)?;
//! file.write_all(b"new")?;
//! assert_eq!(std::fs::read(&path)?, b"old");
//! file.finish()?;
//! assert_eq!(std::fs::read(&path)?, b"new");
//! # std::fs::remove_file(&path)?;
//! # Ok::<(), std::io::Error>(())
//! ```

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// A file on its way; buffered. Dropped before it is finished, it leaves nothing behind.
#[derive(Debug)]
pub struct WholeFile {
    /// What is written to; nothing once it is finished.
    output: Option<BufWriter<File>>,
    /// Where the file stands until it is complete, and where it goes; nothing for devices, pipes and folders that take no new file.
    places: Option<(PathBuf, PathBuf)>,
}

impl WholeFile {
    /// Begins a file. A path to something that is no file, such as a device or a pipe, is written to directly; so is a file in a folder
    /// that takes no new one. A symbolic link stays one.
    ///
    /// # Errors
    /// If the file could not be written.
    pub fn create(path: impl AsRef<Path>) -> io::Result<Self> {
        let path = path.as_ref();
        if let Some((place, file)) = beside(path) {
            let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
            return Ok(Self { output: Some(BufWriter::new(file)), places: Some((place, target)) });
        }
        Ok(Self { output: Some(BufWriter::new(File::create(path)?)), places: None })
    }

    /// Puts the complete file in its place.
    ///
    /// # Errors
    /// If the rest of it cannot be written, or it cannot be renamed; what was there before then stays.
    pub fn finish(mut self) -> io::Result<()> {
        self.flush()?;
        // Closed before it is renamed: some systems rename no open file.
        self.output = None;
        match &self.places {
            Some((place, target)) => fs::rename(place, target)?,
            None => return Ok(()),
        }
        self.places = None;
        Ok(())
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.output.as_mut().map_or(Ok(0), |output| output.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Seek for WholeFile {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.output.as_mut().map_or(Ok(0), |output| output.seek(position))
    }
}

impl Drop for WholeFile {
    fn drop(&mut self) {
        if let Some((place, _)) = self.places.take() {
            // What is left in the buffer must not be written to a file that goes.
            if let Some(output) = self.output.take() {
                let _ = output.into_parts();
            }
            let _ = fs::remove_file(place);
        }
    }
}

/// Writes a whole file.
///
/// # Errors
/// If it cannot be written; what was there before then stays.
pub fn write(path: impl AsRef<Path>, bytes: impl AsRef<[u8]>) -> io::Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(bytes.as_ref())?;
    file.finish()
}

/// A new file beside the one that a path leads to, with its permissions; none where there cannot be one.
fn beside(path: &Path) -> Option<(PathBuf, File)> {
    static FILES: AtomicU64 = AtomicU64::new(0);
    let known = fs::metadata(path).ok();
    if known.as_ref().is_some_and(|known| !known.is_file() || known.permissions().readonly()) {
        return None;
    }
    // A link that leads nowhere: whoever writes through it makes the file it names.
    if known.is_none() && path.is_symlink() {
        return None;
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let mut name = OsString::from(".");
    name.push(target.file_name()?);
    name.push(format!(".{}-{}.part", std::process::id(), FILES.fetch_add(1, Ordering::Relaxed)));
    let place = target.with_file_name(name);
    let file = File::create_new(&place).ok()?;
    if let Some(known) = known
        && file.set_permissions(known.permissions()).is_err()
    {
        let _ = fs::remove_file(&place);
        return None;
    }
    Some((place, file))
}
