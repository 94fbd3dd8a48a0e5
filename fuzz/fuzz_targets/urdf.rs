//! No text makes the URDF reader panic, and every error is placed.
//!
//! `RUSTC_BOOTSTRAP=1 cargo fuzz run urdf fuzz/corpus/urdf fuzz/seeds/urdf -- -dict=fuzz/urdf.dict`

#![no_main]

use libfuzzer_sys::fuzz_target;
use signorini_formats::{LoadOptions, load_urdf_str};

fuzz_target!(|text: &str| {
    for floating_base in [false, true] {
        let options = LoadOptions::default().with_floating_base(floating_base);
        match load_urdf_str(text, "no such folder", &options) {
            Ok(imported) => assert!(imported.report.warnings.iter().all(|w| w.line > 0 && w.count > 0)),
            Err(error) => assert!(error.to_string().starts_with("(URDF text):"), "{error}"),
        }
    }
});
