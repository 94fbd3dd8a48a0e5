//! Lets `cargo build` link the module without Python's library on every system; its symbols come with the interpreter.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
