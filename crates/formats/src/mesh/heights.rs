//! Height fields from files.

use std::path::Path;

use super::read_file;

/// Files larger than this are refused.
const MAX_BYTES: u64 = 256 << 20;

/// Heights of a grid in any unit: row after row from the smallest y to the largest, x rising in each.
pub(crate) struct Grid {
    pub rows: usize,
    pub columns: usize,
    pub heights: Vec<f64>,
}

/// Reads a PNG image, whose first row is the one at the largest y and whose brightness (its first channel) is the height, or MuJoCo's binary
/// format: two 32-bit integers, rows and columns, then 32-bit numbers from the smallest y on.
pub(crate) fn load(path: &Path, most_points: usize) -> Result<Grid, String> {
    let bytes = read_file(path, MAX_BYTES)?;
    let is_image = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    let grid = if is_image { image(&bytes, most_points)? } else { binary(&bytes)? };
    if grid.rows < 2 || grid.columns < 2 || grid.heights.len() > most_points {
        return Err(format!("a grid of {} x {} points: 2 x 2 to {most_points} are read", grid.rows, grid.columns));
    }
    if grid.heights.iter().any(|h| !h.is_finite()) {
        return Err("holds heights that are not finite".into());
    }
    Ok(grid)
}

fn image(bytes: &[u8], most_points: usize) -> Result<Grid, String> {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
    let (rows, columns) = (reader.info().height as usize, reader.info().width as usize);
    if rows.saturating_mul(columns) > most_points {
        return Err(format!("an image of {columns} x {rows} points: at most {most_points} are read"));
    }
    let size = reader.output_buffer_size().ok_or("an image too large")?;
    let mut pixels = vec![0; size];
    let frame = reader.next_frame(&mut pixels).map_err(|e| e.to_string())?;
    let channels = frame.color_type.samples();
    let lines = pixels.chunks_exact(frame.line_size).take(rows);
    let brightness = |line: &[u8]| -> Vec<f64> {
        line.chunks_exact(channels).take(columns).map(|pixel| f64::from(pixel[0])).collect()
    };
    let heights: Vec<f64> = lines.rev().flat_map(brightness).collect();
    Ok(Grid { rows, columns, heights })
}

fn binary(bytes: &[u8]) -> Result<Grid, String> {
    let word = |k: usize| bytes.get(4 * k..4 * k + 4).and_then(|b| b.try_into().ok());
    let size = |k: usize| word(k).and_then(|b| usize::try_from(i32::from_le_bytes(b)).ok());
    let (Some(rows), Some(columns)) = (size(0), size(1)) else {
        return Err("neither a PNG image nor MuJoCo's binary format".into());
    };
    let count = rows.saturating_mul(columns);
    if bytes.len() != count.saturating_mul(4).saturating_add(8) {
        return Err(format!("has {} bytes; {rows} x {columns} heights need another number", bytes.len()));
    }
    let heights = (2..count + 2).filter_map(word).map(|b| f64::from(f32::from_le_bytes(b))).collect();
    Ok(Grid { rows, columns, heights })
}
