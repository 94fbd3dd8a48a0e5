//! No text makes the MJCF reader panic, and every error is placed.
//!
//! `RUSTC_BOOTSTRAP=1 cargo fuzz run mjcf fuzz/corpus/mjcf fuzz/seeds/mjcf -- -dict=fuzz/mjcf.dict`

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    match signorini_formats::load_mjcf_str(text, "no such folder") {
        Ok(imported) => assert!(imported.report.warnings.iter().all(|w| w.line > 0 && w.count > 0)),
        Err(error) => assert!(error.to_string().starts_with("(MJCF text):"), "{error}"),
    }
});
