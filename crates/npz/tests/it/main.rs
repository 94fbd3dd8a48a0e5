//! Integration tests of `signorini-npz`.

mod damage;
mod numpy_files;
mod round_trip;

/// A file of `testdata/`.
fn testdata(name: &str) -> std::path::PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "testdata", name].iter().collect()
}
