//! Films: what is in the file, and that a player of another house shows the frames that went in.

use std::process::Command;

use signorini_render::{Film, Picture, RenderError};

/// A disc that moves to the right before a gradient.
fn frame(k: usize, width: usize, height: usize) -> Picture {
    let pixel = |i: usize| {
        let (x, y) = ((i % width) as f64, (i / width) as f64);
        let inside = (x - 20.0 - 2.0 * k as f64).hypot(y - 0.5 * height as f64) < 12.0;
        if inside { [220, 60, 40] } else { [40, (x * 1.2) as u8, 160] }
    };
    let rgb = (0..width * height).flat_map(pixel).collect();
    Picture::new(width, height, rgb).expect("a picture")
}

fn film(count: usize, size: [usize; 2]) -> Vec<u8> {
    let mut film = Film::new(size, 30.0).expect("a film");
    (0..count).for_each(|k| film.add(&frame(k, size[0], size[1])).expect("a frame"));
    assert_eq!(film.len(), count);
    let mut bytes = Vec::new();
    film.write(&mut bytes).expect("a file");
    bytes
}

/// The content of the box at a path of kinds; of those that begin with other fields, so many bytes are passed over.
fn find<'a>(bytes: &'a [u8], path: &[(&[u8; 4], usize)]) -> &'a [u8] {
    let Some(((kind, skip), rest)) = path.split_first() else { return bytes };
    let mut at = 0;
    while at + 8 <= bytes.len() {
        let length = u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
        if &&bytes[at + 4..at + 8] == kind {
            return find(&bytes[at + 8 + skip..at + length], rest);
        }
        at += length;
    }
    panic!("there is no box {}", String::from_utf8_lossy(*kind));
}

#[test]
fn tables_describe_the_frames() {
    let bytes = film(7, [96, 64]);
    let table = |kind: &'static [u8; 4]| {
        let content = find(&bytes, &[(b"moov", 0), (b"trak", 0), (b"mdia", 0), (b"minf", 0), (b"stbl", 0), (kind, 0)]);
        content.chunks_exact(4).map(|word| u32::from_be_bytes(word.try_into().expect("four bytes"))).collect::<Vec<_>>()
    };
    assert_eq!(table(b"stts"), [0, 1, 7, 3000]);
    assert_eq!(table(b"stss"), [0, 1, 1]);
    let sizes = table(b"stsz");
    assert_eq!(sizes[2], 7);
    let first = table(b"stco")[2] as usize;
    // The frames fill the rest of the file, and each is units of the length that stands before them.
    assert_eq!(first + sizes[3..].iter().sum::<u32>() as usize, bytes.len());
    let mut at = first;
    for size in &sizes[3..] {
        let end = at + *size as usize;
        while at < end {
            at += 4 + u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
        }
        assert_eq!(at, end);
    }
}

#[test]
fn what_no_film_can_have_is_refused() {
    assert!(matches!(Film::new([97, 64], 30.0), Err(RenderError::Film(_))));
    assert!(matches!(Film::new([96, 64], 0.0), Err(RenderError::Film(_))));
    let mut film = Film::new([96, 64], 30.0).expect("a film");
    assert!(matches!(film.add(&frame(0, 64, 64)), Err(RenderError::FrameSize { .. })));
    assert!(film.write(&mut Vec::new()).is_err());
    assert!(Picture::new(2, 2, vec![0; 11]).is_err());
}

/// Decodes with ffmpeg where there is one: on the path, or named by `IMAGEIO_FFMPEG_EXE`.
#[test]
fn another_player_shows_what_went_in() {
    let program = std::env::var("IMAGEIO_FFMPEG_EXE").unwrap_or_else(|_| "ffmpeg".into());
    if Command::new(&program).arg("-version").output().is_err() {
        eprintln!(
            "skipped: there is no ffmpeg here (pip install imageio-ffmpeg, and name its program in IMAGEIO_FFMPEG_EXE)"
        );
        return;
    }
    let (size, count) = ([128, 96], 65);
    let path = std::env::temp_dir().join(format!("signorini-film-another-player-{}.mp4", std::process::id()));
    std::fs::write(&path, film(count, size)).expect("a file");
    let out = Command::new(&program)
        .args(["-v", "error", "-xerror", "-i"])
        .arg(&path)
        .args(["-f", "rawvideo", "-pix_fmt", "rgb24", "-"])
        .output()
        .expect("a decoder");
    std::fs::remove_file(&path).expect("the file is there");
    assert!(out.status.success() && out.stderr.is_empty(), "{}", String::from_utf8_lossy(&out.stderr));
    let bytes = size[0] * size[1] * 3;
    assert_eq!(out.stdout.len(), count * bytes);
    for (k, shown) in out.stdout.chunks_exact(bytes).enumerate() {
        let given = frame(k, size[0], size[1]);
        let squares: f64 = shown.iter().zip(&given.rgb).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
        let decibels = 10.0 * (255.0_f64.powi(2) * bytes as f64 / squares).log10();
        // Colours at half the resolution cost the edge of the disc: 30 dB is a good film.
        assert!(decibels > 30.0, "frame {k}: {decibels} dB");
    }
}
