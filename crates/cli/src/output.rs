//! Writing to the terminal.

use std::io::{ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::error::CliError;
use crate::exit::Exit;
use crate::results::FileName;

/// Prints to standard output. Ends the program: quietly when nobody reads on, with an error when it cannot be written, such as on a full
/// disk. What goes to files is complete by then.
pub fn print(text: &str) {
    let mut out = std::io::stdout().lock();
    if let Err(error) = out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        std::process::exit(unwritten(&error) as i32);
    }
}

/// How the program ends when standard output cannot be written.
pub fn unwritten(error: &std::io::Error) -> Exit {
    if error.kind() == ErrorKind::BrokenPipe {
        return Exit::Success;
    }
    eprintln!("error: cannot write to standard output: {error}");
    Exit::Failure
}

/// Prints one JSON object on one line. Numbers that are not finite become `null`.
pub fn print_json(value: &impl Serialize) {
    let json = serde_json::to_string(value).expect("results have text keys");
    print(&format!("{json}\n"));
}

/// Prints a result in the form asked for.
pub fn print_result<T: Serialize>(result: &T, json: bool, text: impl FnOnce(&T) -> String) {
    if json { print_json(result) } else { print(&text(result)) }
}

/// Prints an error for people, and for machines too where they listen.
pub fn error(error: &CliError, json: bool) {
    eprintln!("error: {error}");
    if json {
        print_json(&serde_json::json!({ "error": error.to_string() }));
    }
}

/// Prints the error of one problem among several.
pub fn problem_error(path: &Path, error: &CliError, json: bool) {
    eprintln!("error: {error}");
    if json {
        print_json(&serde_json::json!({ "problem": FileName::from(path), "error": error.to_string() }));
    }
}

/// Refuses to write over what is read, and two things into one file.
///
/// - `inputs`: files that are read
/// - `outputs`: options that name files, with these
pub fn keep_apart(inputs: &[&Path], outputs: &[(&'static str, Option<&Path>)]) -> Result<(), CliError> {
    let mut taken: Vec<(PathBuf, String)> =
        inputs.iter().filter_map(|path| Some((place(path)?, "what is read".to_owned()))).collect();
    for &(option, path) in outputs {
        let Some(path) = path else { continue };
        let Some(place) = place(path) else { continue };
        if let Some((_, other)) = taken.iter().find(|(known, _)| *known == place) {
            return Err(CliError::Overwrites { option, path: path.to_owned(), other: other.clone() });
        }
        taken.push((place, format!("what {option} writes")));
    }
    Ok(())
}

/// Where a file is, or will be, whatever its path is called; none for devices and pipes, which many may write to, and folders that are not there.
fn place(path: &Path) -> Option<PathBuf> {
    if let Ok(known) = path.canonicalize() {
        return path.is_file().then_some(known);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some(folder.canonicalize().ok()?.join(path.file_name()?))
}

/// A progress bar, drawn only where a terminal watches.
pub fn progress(length: u64, unit: &str) -> ProgressBar {
    if length < 2 || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let template = format!("{{bar:40}} {{pos}}/{{len}} {unit}, {{eta}} left");
    let style = ProgressStyle::with_template(&template).expect("the template is well-formed");
    ProgressBar::new(length).with_style(style)
}

/// A line for work whose length is not known, drawn only where a terminal watches; its message says how far it is.
pub fn spinner() -> ProgressBar {
    if std::io::stderr().is_terminal() { ProgressBar::new_spinner() } else { ProgressBar::hidden() }
}
