//! Files as they are.

use std::path::Path;

/// All bytes of a regular file of at most `limit` bytes.
pub(crate) fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, String> {
    let metadata = std::fs::metadata(path).map_err(|e| e.to_string())?;
    if !metadata.is_file() {
        return Err("not a regular file".into());
    }
    if metadata.len() > limit {
        return Err(format!("larger than {limit} bytes"));
    }
    std::fs::read(path).map_err(|e| e.to_string())
}
