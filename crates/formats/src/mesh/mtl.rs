//! MTL: the colours that Wavefront OBJ files name.

use std::path::Path;

use super::painted::{Paint, Source};

/// The materials of a library by name: diffuse colour, opacity, diffuse image. What is not a number is passed over; only pictures depend on it.
///
/// - `folder`: in which images lie
pub(super) fn read(text: &str, folder: &Path) -> Vec<(String, Paint)> {
    let mut materials: Vec<(String, Paint)> = Vec::new();
    for line in text.lines() {
        let (word, rest) = line.trim().split_once(char::is_whitespace).unwrap_or((line.trim(), ""));
        let rest = rest.trim();
        if word == "newmtl" {
            materials.push((rest.to_owned(), Paint::default()));
            continue;
        }
        let Some((_, paint)) = materials.last_mut() else { continue };
        let numbers: Vec<f32> = rest.split_ascii_whitespace().map_while(|w| w.parse().ok()).collect();
        let rgba = paint.rgba.unwrap_or([1.0; 4]);
        match (word, &numbers[..]) {
            ("Kd", &[r, g, b, ..]) => paint.rgba = Some([r, g, b, rgba[3]]),
            ("d", &[opacity, ..]) => paint.rgba = Some([rgba[0], rgba[1], rgba[2], opacity]),
            ("Tr", &[clearness, ..]) => paint.rgba = Some([rgba[0], rgba[1], rgba[2], 1.0 - clearness]),
            ("map_Kd", _) => paint.image = file_of(rest).map(|file| Source::File(folder.join(file))),
            _ => {}
        }
    }
    for (_, paint) in &mut materials {
        // Exporters write black below an image, which would show nothing.
        if let (Some([r, g, b, a]), Some(_)) = (paint.rgba, &paint.image)
            && r + g + b < 0.05
        {
            paint.rgba = Some([1.0, 1.0, 1.0, a]);
        }
        // An opacity of zero is how exporters that mean its opposite say that nothing is to be seen through.
        if let Some(rgba) = &mut paint.rgba
            && rgba[3] <= 0.0
        {
            rgba[3] = 1.0;
        }
    }
    materials
}

/// The file of a `map_…` line: all of it, or after options its last word.
fn file_of(rest: &str) -> Option<String> {
    let file = if rest.starts_with('-') { rest.split_ascii_whitespace().last()? } else { rest };
    (!file.is_empty()).then(|| file.replace('\\', "/"))
}
