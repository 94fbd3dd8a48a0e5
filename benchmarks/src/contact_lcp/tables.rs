//! What is printed of the records.

use std::collections::BTreeMap;

use super::{Outcome, Record};
use crate::table::{markdown, quantile};

/// Lower ends of the size classes of the standard LCP.
const CLASSES: [usize; 6] = [0, 30, 80, 160, 320, 900];

/// Problems with fewer contacts tell nothing about growth.
const GROWTH_FROM: usize = 16;

/// Prints all tables of a run as Markdown.
pub fn print_all(records: &[Record]) {
    let (growth, usual): (Vec<&Record>, Vec<&Record>) = records.iter().partition(|record| record.growth);
    let sizes = |record: &Record| {
        let class = CLASSES.iter().rposition(|&low| record.size >= low).unwrap_or(0);
        let end = CLASSES.get(class + 1).map_or("…".to_owned(), |next| (next - 1).to_string());
        format!("{:3}–{end}", CLASSES[class])
    };
    section("By family", &by(&usual, "family", |record| record.family.clone()));
    section("By size of the standard LCP", &by(&usual, "size", sizes));
    section("By friction directions", &by(&usual, "directions", |record| format!("{:2}", record.directions)));
    let peers: Vec<String> = usual
        .iter()
        .flat_map(|r| r.peers.keys().cloned())
        .collect::<std::collections::BTreeSet<_>>()
        .into_iter()
        .collect();
    if !peers.is_empty() {
        section("Solved %, by family", &solved_by_all(&usual, &peers, "family", |record| record.family.clone()));
        section("Solved %, by size", &solved_by_all(&usual, &peers, "size", sizes));
        section("Time of a peer / our cold time, where both solve: median (pairs)", &ratios(&usual, &peers, sizes));
        section("Claims", &claims(&usual, &peers));
    }
    section("Without a solution", &denied(&usual));
    section("Growth", &series(&growth));
    failures(records);
}

fn section(title: &str, rows: &[Vec<String>]) {
    println!("\n### {title}\n");
    print!("{}", markdown(rows));
}

fn header(text: &str) -> Vec<String> {
    text.split('|').map(str::to_owned).collect()
}

fn groups<'a>(records: &[&'a Record], group: impl Fn(&Record) -> String) -> BTreeMap<String, Vec<&'a Record>> {
    let mut groups: BTreeMap<String, Vec<&Record>> = BTreeMap::new();
    records.iter().for_each(|record| groups.entry(group(record)).or_default().push(record));
    if groups.len() > 1 {
        groups.insert("~ all".to_owned(), records.to_vec());
    }
    groups
}

/// Our solver's results, one line for each group.
fn by(records: &[&Record], title: &str, group: impl Fn(&Record) -> String) -> Vec<Vec<String>> {
    let text = "problems|solvable|solved %|denied, of the rest|open|median residual|worst residual|cold|warm|one LU|cold / LU|warm / LU";
    let mut rows = vec![header(&format!("{title}|{text}"))];
    for (name, records) in groups(records, group) {
        let solvable: Vec<&&Record> = records.iter().filter(|r| r.is_solvable()).collect();
        let solved: Vec<&&Record> = solvable.iter().copied().filter(|r| r.cold.solves()).collect();
        let rest = records.len() - solvable.len();
        let denied = records.iter().filter(|r| !r.is_solvable() && r.is_denied()).count();
        let mut residuals: Vec<f64> = solved.iter().filter_map(|r| r.cold.residual).collect();
        let median = |value: &dyn Fn(&Record) -> Option<f64>| -> Option<f64> {
            let mut values: Vec<f64> = solved.iter().filter_map(|r| value(r)).collect();
            (!values.is_empty()).then(|| quantile(&mut values, 0.5))
        };
        let in_lu = |time: Option<f64>, r: &Record| Some(time? / r.lu_seconds?);
        rows.push(vec![
            name,
            records.len().to_string(),
            solvable.len().to_string(),
            percent(solved.len(), solvable.len()),
            format!("{denied} of {rest}"),
            (rest - denied).to_string(),
            format!("{:.1e}", quantile(&mut residuals, 0.5)),
            format!("{:.1e}", residuals.last().copied().unwrap_or(0.0)),
            time(median(&|r| r.cold.seconds)),
            time(median(&|r| r.warm.seconds)),
            time(median(&|r| r.lu_seconds)),
            number(median(&|r| in_lu(r.cold.seconds, r))),
            number(median(&|r| in_lu(r.warm.seconds, r))),
        ]);
    }
    rows
}

/// The share that everybody solves of the problems that everybody was given and that have a solution.
fn solved_by_all(
    records: &[&Record],
    peers: &[String],
    title: &str,
    group: impl Fn(&Record) -> String,
) -> Vec<Vec<String>> {
    let mut rows = vec![header(&format!("{title}|problems|signorini|{}", peers.join("|")))];
    let given: Vec<&Record> = records.iter().copied().filter(|r| r.is_solvable() && !r.peers.is_empty()).collect();
    for (name, records) in groups(&given, group) {
        let share =
            |solves: &dyn Fn(&Record) -> bool| percent(records.iter().filter(|r| solves(r)).count(), records.len());
        let mut row = vec![name, records.len().to_string(), share(&|r| r.cold.solves())];
        row.extend(peers.iter().map(|peer| share(&|r| outcome(r, peer).is_some_and(Outcome::solves))));
        rows.push(row);
    }
    rows
}

/// How many times longer a peer takes. A warm peer is compared with our warm time.
fn ratios(records: &[&Record], peers: &[String], group: impl Fn(&Record) -> String) -> Vec<Vec<String>> {
    let mut rows = vec![header(&format!("size|{}|fastest peer", peers.join("|")))];
    let cold_peers = || peers.iter().filter(|peer| !peer.ends_with("_warm"));
    for (name, records) in groups(records, group) {
        let cell = |ratio: &dyn Fn(&Record) -> Option<f64>| {
            let solved = records.iter().filter(|r| r.cold.solves());
            let mut all: Vec<f64> = solved.filter_map(|r| ratio(r)).collect();
            if all.is_empty() {
                "–".to_owned()
            } else {
                format!("{} ({})", number(Some(quantile(&mut all, 0.5))), all.len())
            }
        };
        let seconds = |r: &Record, peer: &str| outcome(r, peer).filter(|o| o.solves())?.seconds;
        let mut row = vec![name];
        for peer in peers {
            let own = |r: &Record| if peer.ends_with("_warm") { r.warm.seconds } else { r.cold.seconds };
            row.push(cell(&|r| Some(seconds(r, peer)? / own(r)?)));
        }
        let fastest = |r: &Record| cold_peers().filter_map(|peer| seconds(r, peer)).reduce(f64::min);
        row.push(cell(&|r| Some(fastest(r)? / r.cold.seconds?)));
        rows.push(row);
    }
    rows
}

/// Who claims what, over all problems.
fn claims(records: &[&Record], peers: &[String]) -> Vec<Vec<String>> {
    let mut rows =
        vec![header("solver|runs|claims a solution that is none|solves without saying so|time-outs|crashes")];
    let mut line = |name: &str, outcomes: Vec<&Outcome>| {
        let count = |test: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|o| test(o)).count().to_string();
        rows.push(vec![
            name.to_owned(),
            outcomes.len().to_string(),
            count(&Outcome::is_wrong),
            count(&|o| !o.claims && o.solves()),
            count(&|o| o.status == "time-out"),
            count(&|o| o.status == "crash"),
        ]);
    };
    line("signorini", records.iter().map(|r| &r.cold).collect());
    for peer in peers {
        line(peer, records.iter().filter_map(|r| outcome(r, peer)).collect());
    }
    rows
}

fn outcome<'a>(record: &'a Record, peer: &str) -> Option<&'a Outcome> {
    record.peers.get(peer).map(|p| &p.outcome)
}

/// Problems that our solver denies, beside the same problems with gaps that do not contradict each other.
fn denied(records: &[&Record]) -> Vec<Vec<String>> {
    let mut rows = vec![header("problem|family|contacts|size|status|time|with open gaps|ratio|fastest peer's answer")];
    for record in records.iter().filter(|r| r.is_denied() && !r.is_solvable()) {
        let opened = record.opened.as_ref().and_then(|o| o.seconds);
        let peers = record.peers.iter().filter(|(name, peer)| !name.ends_with("_warm") && !peer.outcome.claims);
        rows.push(vec![
            record.name.clone(),
            record.family.clone(),
            record.contacts.to_string(),
            record.size.to_string(),
            record.cold.status.clone(),
            time(record.cold.seconds),
            time(opened),
            number(record.cold.seconds.zip(opened).map(|(a, b)| a / b)),
            time(peers.filter_map(|(_, peer)| peer.outcome.seconds).reduce(f64::min)),
        ]);
    }
    rows
}

/// Times of the series with exponents of the number of contacts.
fn series(records: &[&Record]) -> Vec<Vec<String>> {
    let mut rows = vec![header("series|directions|cold: contacts: time|exponent|warm: contacts: time|exponent")];
    let mut all: BTreeMap<(String, usize), Vec<&Record>> = BTreeMap::new();
    records.iter().for_each(|r| all.entry((r.family.clone(), r.directions)).or_default().push(r));
    for ((name, directions), mut records) in all {
        records.sort_by_key(|r| r.contacts);
        let mut row = vec![name, directions.to_string()];
        for outcome in [|r: &Record| r.cold.clone(), |r: &Record| r.warm.clone()] {
            let cell = |r: &&Record| {
                let o = outcome(r);
                let mark = if o.solves() { String::new() } else { format!(" ({})", word(&o)) };
                format!("{}: {}{mark}", r.contacts, time(o.seconds))
            };
            row.push(records.iter().map(cell).collect::<Vec<_>>().join("; "));
            let solved = records.iter().filter(|r| r.contacts >= GROWTH_FROM && outcome(r).solves());
            let points: Vec<(f64, f64)> =
                solved.filter_map(|r| Some(((r.contacts as f64).ln(), outcome(r).seconds?.ln()))).collect();
            row.push(slope(&points).map_or("–".to_owned(), |s| format!("{s:.2}")));
        }
        rows.push(row);
    }
    rows
}

/// Least-squares slope through at least three points.
fn slope(points: &[(f64, f64)]) -> Option<f64> {
    if points.len() < 3 {
        return None;
    }
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xx, xy) = points.iter().fold((0.0, 0.0), |(xx, xy), p| (xx + (p.0 - x).powi(2), xy + (p.0 - x) * (p.1 - y)));
    Some(xy / xx)
}

/// Names what our solver did not solve, and what was left out.
fn failures(records: &[Record]) {
    println!("\n### Not solved by our solver\n");
    let mut any = false;
    let list = records.iter().filter(|r| !r.cold.solves() || r.cold.is_wrong() || !r.warm.solves());
    for record in list.filter(|r| r.is_solvable() || !r.is_denied()) {
        any = true;
        let residual = record.cold.residual.map_or("no point".to_owned(), |r| format!("residual {r:.1e}"));
        let why = if record.promised {
            "promised by theory"
        } else if record.is_solvable() {
            "somebody solves it"
        } else {
            "nobody solves it"
        };
        println!(
            "- {} ({}, {} contacts): cold {}, {residual}; warm {}; {why}",
            record.name,
            record.family,
            record.contacts,
            record.cold.status,
            word(&record.warm)
        );
    }
    if !any {
        println!("nothing");
    }
    let mut left_out: BTreeMap<&String, usize> = BTreeMap::new();
    records.iter().filter_map(|r| r.left_out.as_ref()).for_each(|reason| *left_out.entry(reason).or_default() += 1);
    for (reason, count) in left_out {
        println!("\nLeft out of {count} problems: {reason}");
    }
}

/// How a solve ended; a warm one is not tried where the cold one does not end.
fn word(outcome: &Outcome) -> &str {
    if outcome.status.is_empty() { "not tried" } else { &outcome.status }
}

fn percent(part: usize, whole: usize) -> String {
    if whole == 0 { "–".to_owned() } else { format!("{:.1}", 100.0 * part as f64 / whole as f64) }
}

fn number(value: Option<f64>) -> String {
    match value {
        None => "–".to_owned(),
        Some(x) if x >= 100.0 => format!("{x:.0}"),
        Some(x) if x >= 10.0 => format!("{x:.1}"),
        Some(x) => format!("{x:.2}"),
    }
}

fn time(seconds: Option<f64>) -> String {
    let Some(s) = seconds else { return "–".to_owned() };
    let (value, unit) = if s < 1e-3 {
        (1e6 * s, "µs")
    } else if s < 1.0 {
        (1e3 * s, "ms")
    } else {
        (s, "s")
    };
    format!("{} {unit}", number(Some(value)))
}
