//! The reference of the command line on the site is what `--help` says.

use std::fmt::Write;
use std::path::Path;

use crate::support::Folder;

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/reference/command-line.md");

const BEGINNING: &str = "\
# Command line

What `signorini COMMAND --help` prints; a test compares this page with it. The [guide](../guide/command-line.md) shows the commands at work.
";

/// The page as it must be: the help of the command and of each of its commands.
fn page(folder: &Folder) -> String {
    let help = |words: &[&str]| folder.run(&[words, &["--help"]].concat()).exits(0).stdout;
    let overview = help(&[]);
    let listed = overview.split("Commands:").nth(1).expect("a list of commands").trim_start_matches('\n');
    let commands = listed.lines().map_while(|line| line.strip_prefix("  ")?.split_whitespace().next());
    let mut page = BEGINNING.to_owned();
    let mut add = |title: &str, text: &str| {
        let text: Vec<&str> = text.lines().map(str::trim_end).collect();
        write!(page, "\n## `{title}`\n\n```text\n{}\n```\n", text.join("\n").trim_end()).expect("a string takes it");
    };
    add("signorini", &overview);
    for command in commands.filter(|&command| command != "help") {
        add(&format!("signorini {command}"), &help(&[command]));
    }
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
    for command in ["simulate", "check"] {
        assert!(wanted.contains(&format!("## `signorini {command}`")), "{wanted}");
    }
    let differs = wanted.lines().zip(found.lines()).position(|(a, b)| a != b);
    assert!(
        wanted == found,
        "{PAGE}:{} is not what --help says; renew it: SIGNORINI_RENEW=1 cargo test -p signorini-cli reference",
        differs.map_or(wanted.lines().count().min(found.lines().count()), |line| line + 1)
    );
}
