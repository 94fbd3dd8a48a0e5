//! Small parts of printing and finding that all programs need.

use std::path::PathBuf;

/// A folder of the data that is kept beside the repository: `../shared/<part>` seen from the repository's root.
pub fn shared(part: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared")).join(part)
}

/// A Markdown table; the first row is the header.
pub fn markdown(rows: &[Vec<String>]) -> String {
    let columns = rows.first().map_or(0, Vec::len);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|x| x.chars().count()).max().unwrap_or(0).max(3);
    let mut text = String::new();
    for (k, row) in rows.iter().enumerate() {
        for (c, cell) in row.iter().enumerate() {
            text += &format!("| {cell:<width$} ", width = width(c));
        }
        text += "|\n";
        if k == 0 {
            (0..columns).for_each(|c| text += &format!("|{}", "-".repeat(width(c) + 2)));
            text += "|\n";
        }
    }
    text
}

/// The `q`-quantile (0 to 1) of a list that is sorted here; 0 for an empty list.
pub fn quantile(values: &mut [f64], q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    values.get((last as f64 * q).round() as usize).copied().unwrap_or(0.0)
}
