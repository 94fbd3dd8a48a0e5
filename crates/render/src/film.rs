//! Films: H.264 in an MP4 file, which browsers, slides and journals play.

use std::io::Write;

use rusty_h264_common::YuvFrame;
use rusty_h264_encoder::{Encoder, EncoderConfig};

use crate::error::RenderError;
use crate::mp4::{Sample, Track};
use crate::picture::Picture;

/// Quantization of a film: at 20 differences to the pictures are not seen.
const QUANTIZATION: u8 = 20;
/// Frames from one that stands alone to the next, which is where players can jump to: two seconds at 30 a second.
const GROUP: u32 = 60;

/// A film in the making. Frames are encoded as they come, so that a long film takes little memory.
pub struct Film {
    encoder: Encoder,
    size: [usize; 2],
    rate: f64,
    parameters: [Vec<u8>; 2],
    samples: Vec<Sample>,
}

impl Film {
    /// An empty film.
    ///
    /// - `size`: width and height of the frames, both even
    /// - `rate`: frames per second
    ///
    /// # Errors
    /// [`RenderError::Film`] for an odd size, or one that the encoder refuses.
    pub fn new(size: [usize; 2], rate: f64) -> Result<Self, RenderError> {
        let [width, height] = size;
        if width % 2 == 1 || height % 2 == 1 || width == 0 || height == 0 {
            return Err(RenderError::Film(format!("frames of {width} x {height} pixels: H.264 needs even sizes")));
        }
        if !(rate.is_finite() && rate > 0.0) {
            return Err(RenderError::Film(format!("{rate} frames per second")));
        }
        let mut settings = EncoderConfig::new(width, height);
        (settings.qp, settings.gop_size, settings.framerate) = (QUANTIZATION, GROUP, rate as f32);
        // The lookahead would hold back frames.
        settings.mbtree = false;
        settings.level_idc = level(width, height, rate);
        let encoder = Encoder::new(settings).map_err(|e| RenderError::Film(format!("{e:?}")))?;
        Ok(Self { encoder, size, rate, parameters: Default::default(), samples: Vec::new() })
    }

    /// Number of frames so far.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether it has no frame yet.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// [`RenderError::FrameSize`], [`RenderError::Film`].
    pub fn add(&mut self, frame: &Picture) -> Result<(), RenderError> {
        let found = [frame.width, frame.height];
        if found != self.size {
            return Err(RenderError::FrameSize { expected: self.size, found });
        }
        let unit = self.encoder.try_encode(&to_yuv(frame)).map_err(|e| RenderError::Film(format!("{e:?}")))?;
        let mut sample = Sample { data: Vec::with_capacity(unit.len() + 16), key: false };
        for nal in units(&unit) {
            // Kinds of Rec. ITU-T H.264, table 7-1: 5 a picture that stands alone, 7 and 8 the parameters of the film.
            match nal.first().map(|head| head & 31) {
                Some(7) => self.parameters[0] = nal.to_vec(),
                Some(8) => self.parameters[1] = nal.to_vec(),
                kind => {
                    sample.key |= kind == Some(5);
                    sample.data.extend((nal.len() as u32).to_be_bytes());
                    sample.data.extend(nal);
                }
            }
        }
        self.samples.push(sample);
        Ok(())
    }

    /// Writes the film.
    ///
    /// # Errors
    /// [`RenderError::Film`] where it has no frame, [`RenderError::Write`].
    pub fn write(&self, mut out: impl Write) -> Result<(), RenderError> {
        let [sequence, picture] = &self.parameters;
        if self.samples.is_empty() || sequence.len() < 4 {
            return Err(RenderError::Film("it has no frame".into()));
        }
        if self.samples.iter().map(|sample| sample.data.len() as u64).sum::<u64>() > u64::from(u32::MAX) / 2 {
            return Err(RenderError::Film("it has more than 2 GB: make it in parts".into()));
        }
        let track = Track { size: self.size, rate: self.rate, sequence, picture, samples: &self.samples };
        out.write_all(&track.file())?;
        Ok(out.flush()?)
    }
}

/// The least level (times ten) whose decoders can keep up: macroblocks a frame and a second of Rec. ITU-T H.264, table A-1.
fn level(width: usize, height: usize, rate: f64) -> u8 {
    const LEVELS: [(u8, f64, f64); 6] = [
        (30, 1620.0, 40_500.0),
        (31, 3600.0, 108_000.0),
        (40, 8192.0, 245_760.0),
        (42, 8704.0, 522_240.0),
        (51, 36_864.0, 983_040.0),
        (52, 36_864.0, 2_073_600.0),
    ];
    let blocks = (width.div_ceil(16) * height.div_ceil(16)) as f64;
    let enough = |&&(_, frame, second): &&(u8, f64, f64)| blocks <= frame && blocks * rate <= second;
    LEVELS.iter().find(enough).map_or(62, |level| level.0)
}

/// The units of a stream with start codes (Rec. ITU-T H.264, annex B).
fn units(stream: &[u8]) -> impl Iterator<Item = &[u8]> {
    let starts: Vec<usize> = (3..=stream.len()).filter(|&i| stream[i - 3..i] == [0, 0, 1]).collect();
    let ends = starts.iter().skip(1).map(|start| start - 3).chain([stream.len()]).collect::<Vec<_>>();
    starts.into_iter().zip(ends).map(move |(start, end)| {
        let unit = &stream[start..end];
        let zeros = unit.iter().rev().take_while(|byte| **byte == 0).count();
        &unit[..unit.len() - zeros]
    })
}

/// To brightness and colour in the range of video, by Rec. ITU-R BT.601; colours are means of four pixels.
fn to_yuv(picture: &Picture) -> YuvFrame {
    let (width, height) = (picture.width, picture.height);
    let mut frame = YuvFrame::black(width, height);
    let at = |x: usize, y: usize| {
        let i = 3 * (y * width + x);
        [0, 1, 2].map(|k| f32::from(picture.rgb[i + k]) / 255.0)
    };
    for y in 0..height {
        for x in 0..width {
            let [r, g, b] = at(x, y);
            frame.y[y * width + x] = (16.5 + 65.481 * r + 128.553 * g + 24.966 * b) as u8;
        }
    }
    for y in 0..height / 2 {
        for x in 0..width / 2 {
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| at(2 * x + i, 2 * y + j));
            let [r, g, b] = [0, 1, 2].map(|k| 0.25 * four.iter().map(|pixel| pixel[k]).sum::<f32>());
            let place = y * (width / 2) + x;
            frame.u[place] = (128.5 - 37.797 * r - 74.203 * g + 112.0 * b) as u8;
            frame.v[place] = (128.5 + 112.0 * r - 93.786 * g - 18.214 * b) as u8;
        }
    }
    frame
}
