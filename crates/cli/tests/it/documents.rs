//! The command lines in the documents are ones that the command takes.

use std::path::{Path, PathBuf};

use crate::support::Folder;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// The pages that users read: the Markdown files of the repository, without what says how it was in earlier versions.
fn pages() -> Vec<PathBuf> {
    let (mut folders, mut pages) = (vec![PathBuf::from(ROOT)], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder can be read").flatten() {
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            if path.is_dir() && !name.starts_with('.') && !["target", "build", "node_modules"].contains(&&*name) {
                folders.push(path);
            } else if name.ends_with(".md") && name != "CHANGELOG.md" {
                pages.push(path);
            }
        }
    }
    pages
}

/// The command lines of a page: lines of its blocks, and words between backticks that have an option with its value.
fn command_lines(text: &str) -> Vec<Vec<String>> {
    let mut lines = Vec::new();
    for (k, part) in text.split("```").enumerate() {
        if k % 2 == 1 {
            lines.extend(part.lines().filter_map(words));
        } else {
            lines.extend(part.split('`').skip(1).step_by(2).filter_map(words));
        }
    }
    lines
}

/// The words behind `signorini`, up to a comment; none where the line calls something else, or is of another language.
fn words(line: &str) -> Option<Vec<String>> {
    let line = line.trim().trim_start_matches("cargo run --release --bin ").replace("signorini -- ", "signorini ");
    let rest = line.strip_prefix("signorini ")?.trim_start();
    let words = rest.split_whitespace().take_while(|word| !word.starts_with('#'));
    rest.starts_with(|first: char| first.is_lowercase() || first == '-').then(|| words.map(str::to_owned).collect())
}

/// Up to `--help`, which is the last word, every word is read: an option that there is not, or a value that it does not take, is refused.
#[test]
fn command_lines_in_the_documents_are_understood() {
    let folder = Folder::new("documents");
    let mut seen = 0;
    for page in pages() {
        let text = std::fs::read_to_string(&page).expect("a page can be read");
        for words in command_lines(&text) {
            let line: Vec<&str> = words.iter().map(String::as_str).chain(["--help"]).collect();
            let done = folder.run(&line);
            let name = page.strip_prefix(Path::new(ROOT)).unwrap_or(&page).display().to_string();
            assert_eq!(done.code, 0, "{name}: signorini {}\n{}", words.join(" "), done.stderr);
            seen += 1;
        }
    }
    assert!(seen > 80, "only {seen} command lines were found");
}
