//! No text makes the SDF reader panic, and every error is placed.
//!
//! `RUSTC_BOOTSTRAP=1 cargo fuzz run sdf fuzz/corpus/sdf fuzz/seeds/sdf -- -dict=fuzz/sdf.dict`

#![no_main]

use libfuzzer_sys::fuzz_target;
use signorini_formats::{LoadOptions, load_sdf_str};

fuzz_target!(|text: &str| match load_sdf_str(text, "no such folder", &LoadOptions::default()) {
    Ok(imported) => assert!(imported.report.warnings.iter().all(|w| w.line > 0 && w.count > 0)),
    Err(error) => assert!(error.to_string().starts_with("(SDF text):"), "{error}"),
});
