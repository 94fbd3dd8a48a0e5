//! `signorini view`: what it prints, and that its page is there. The page itself is tested in `viewer/test`.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

use serde_json::Value;

use crate::support::{BOX, Folder};

/// The command while it runs.
pub struct Running(Child);

impl Running {
    pub fn start(folder: &Folder, words: &[&str]) -> (Self, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_signorini"));
        command.args(words).current_dir(folder.path("")).stdout(Stdio::piped());
        let mut child = command.spawn().expect("the command starts");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("piped")).read_line(&mut line).expect("a line");
        (Self(child), line)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What the server answers at an address.
pub fn get(address: &str) -> String {
    let (host, path) = address.strip_prefix("http://").expect("http").split_once('/').expect("a path");
    let mut stream = TcpStream::connect(host).expect("the server listens");
    write!(stream, "GET /{path} HTTP/1.1\r\nHost: {host}\r\n\r\n").expect("it takes a request");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("text");
    answer
}

#[test]
fn the_address_that_is_printed_has_the_page() {
    let folder = Folder::new("view");
    folder.write("box.xml", BOX);
    let (_running, line) = Running::start(&folder, &["view", "box.xml", "--no-open", "--paused", "--json"]);
    let shown: Value = serde_json::from_str(&line).expect("JSON");
    assert_eq!((&shown["model"], &shown["source"]), (&"box on a floor".into(), &"box.xml".into()));
    let page = get(shown["address"].as_str().expect("an address"));
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("box on a floor") && page.contains("box.xml"));

    let port = shown["address"].as_str().unwrap().split([':', '/']).nth(4).unwrap().to_owned();
    folder.run(&["view", "box.xml", "--no-open", "--port", &port]).exits(1).complains(&[&port, "another port"]);
}

#[test]
fn without_a_model_it_shows_the_house_of_cards() {
    let folder = Folder::new("view_default");
    let (_running, line) = Running::start(&folder, &["view", "--no-open"]);
    assert!(line.starts_with("house of cards (scenes/house_of_cards.xml): http://127.0.0.1:"), "{line}");
}

#[test]
fn wrong_arguments_are_refused() {
    let folder = Folder::new("view_wrong");
    folder.run(&["view", "absent.xml", "--no-open"]).exits(1).complains(&["absent.xml"]);
    folder.run(&["view", "--no-open", "--speed", "1e6"]).exits(1).complains(&["speed = 1000000", "100"]);
    folder.run(&["view", "--no-open", "--speed", "-1"]).exits(64);
    folder.run(&["view", "--no-open", "--port", "65536"]).exits(64);
    let help = folder.run(&["help", "view"]).exits(0);
    assert!(["--no-open", "--port", "--paused", "this machine only"].iter().all(|word| help.stdout.contains(word)));
}
