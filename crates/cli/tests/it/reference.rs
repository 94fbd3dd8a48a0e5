//! The reference of the command line on the site is what `--help` says.

use std::fmt::Write;
use std::path::Path;

use crate::support::Folder;

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/reference/command-line.md");

const BEGINNING: &str = "\
# Command line

What `signorini COMMAND --help` prints; a test compares this page with it. The [guide](../guide/command-line.md) shows the commands at work.
";

/// Adds the help of a command to the page, and that of each of its commands.
fn add(page: &mut String, folder: &Folder, words: &[&str]) {
    let help = folder.run(&[words, &["--help"]].concat()).exits(0).stdout;
    let text: Vec<&str> = help.lines().map(str::trim_end).collect();
    let title = [&["signorini"], words].concat().join(" ");
    let level = "#".repeat(2 + words.len().saturating_sub(1));
    write!(page, "\n{level} `{title}`\n\n```text\n{}\n```\n", text.join("\n").trim_end()).expect("a string takes it");
    let Some(listed) = help.split("\nCommands:\n").nth(1) else { return };
    let commands = listed.lines().map_while(|line| line.strip_prefix("  ")?.split_whitespace().next());
    for command in commands.filter(|&command| command != "help") {
        add(page, folder, &[words, &[command]].concat());
    }
}

/// The page as it must be.
fn page(folder: &Folder) -> String {
    let mut page = BEGINNING.to_owned();
    add(&mut page, folder, &[]);
    page
}

#[test]
fn command_line_reference_is_what_help_says() {
    let path = Path::new(PAGE);
    let wanted = page(&Folder::new("reference"));
    if std::env::var_os("SIGNORINI_RENEW").is_some() {
        std::fs::write(path, &wanted).expect("the page can be written");
    }
    let found = std::fs::read_to_string(path).expect("the page can be read");
    for command in ["simulate", "check", "make heap"] {
        assert!(wanted.contains(&format!("# `signorini {command}`")), "{wanted}");
    }
    let differs = wanted.lines().zip(found.lines()).position(|(a, b)| a != b);
    assert!(
        wanted == found,
        "{PAGE}:{} is not what --help says; renew it: SIGNORINI_RENEW=1 cargo test -p signorini-cli reference",
        differs.map_or(wanted.lines().count().min(found.lines().count()), |line| line + 1)
    );
}
