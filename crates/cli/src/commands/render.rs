//! `signorini render`.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use indicatif::ProgressBar;
use serde::Serialize;
use signorini::Simulation;
use signorini::render::{
    Background, Film, Picture, RenderError, RenderSettings, Renderer, View, write_animated_png, write_png,
};

use crate::args::{ModelArguments, StartArguments, StepArguments, positive};
use crate::error::CliError;
use crate::exit::Exit;
use crate::interrupt::Interrupt;
use crate::loading::{load_model, start};
use crate::results::FileName;
use crate::{clock, output};

const HELP: &str = "\
The ending of --out says what is made: .png a picture, .mp4 a film (H.264), .apng one without loss, which browsers show. The picture is taken --time
seconds after the start, a film shows the time up to there. No window and no graphics card is needed.

Examples:
  signorini render robot.xml --out robot.png --samples 32
  signorini render --scene wall --time 1 --out wall.mp4
  signorini render robot.xml --camera front --size 1920x1080 --out front.png";

/// Frames that the file of a film counts: PNG's integers end here.
const MOST_FRAMES: i32 = i32::MAX;

/// Arguments of `render`.
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelArguments,
    /// The file to write.
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Camera of the model; without one the scene fills the picture.
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Direction of the view without a camera: degrees around the world's z axis from x, and up.
    #[arg(long, value_name = "AZIMUTH,ELEVATION", default_value = "120,-20", value_parser = angles, allow_hyphen_values = true, conflicts_with = "camera")]
    pub look: [f64; 2],
    /// Pixels, width by height.
    #[arg(long, value_name = "WxH", default_value = "640x480", value_parser = size)]
    pub size: [usize; 2],
    /// Simulated time before the picture, or length of the film, s. [default: 0 for a picture, 2 for a film]
    #[arg(long, value_name = "S", value_parser = not_negative)]
    pub time: Option<f64>,
    /// Frames of a film per second of simulated time. [default: 30]
    #[arg(long, value_name = "N", value_parser = positive)]
    pub fps: Option<f64>,
    /// Rays for every pixel: 1 with more at edges, for films; 16 or more for soft shadows, for paper. [default: 16 for a picture, 1 for a film]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub samples: Option<u16>,
    /// What is behind everything.
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = BackgroundName::Sky)]
    pub background: BackgroundName,
    /// Visibility groups that are shown (MJCF `group`).
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "0,1,2")]
    pub groups: Vec<u8>,
    /// The state to start from.
    #[command(flatten)]
    pub start: StartArguments,
    /// How steps are made.
    #[command(flatten)]
    pub step: StepArguments,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

impl Arguments {
    /// Frames per second of simulated time.
    fn rate(&self) -> f64 {
        self.fps.unwrap_or(30.0)
    }

    /// How pictures are made; those of films with fewer rays.
    fn settings(&self, film: bool) -> RenderSettings {
        RenderSettings::default()
            .with_samples(self.samples.map_or(if film { 1 } else { 16 }, usize::from))
            .with_groups(self.groups.clone())
            .with_background(match self.background {
                BackgroundName::Sky => Background::Sky,
                BackgroundName::White => Background::White,
            })
    }
}

/// What is behind everything, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BackgroundName {
    /// A bright sky with a horizon.
    Sky,
    /// White, as paper.
    White,
}

/// What was made.
#[derive(Serialize)]
struct Rendered {
    out: FileName,
    model: String,
    width: usize,
    height: usize,
    frames: usize,
    /// Time of the last frame, s.
    time: f64,
    /// Wall time of a frame, s.
    seconds_per_frame: f64,
}

/// Makes the picture or the film.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    let form = Form::of(&arguments.out)?;
    output::keep_apart(&arguments.model.files(), &[("--out", Some(&arguments.out))])?;
    if arguments.fps.is_some() && form == Form::Picture {
        return Err(CliError::UnusedOption { option: "--fps", needs: "films (.mp4, .apng)" });
    }
    let film = form != Form::Picture;
    let loaded = load_model(&arguments.model)?;
    let simulation = start(&loaded, &arguments.start, arguments.step.settings()?)?;
    let renderer = Renderer::new(Arc::clone(&loaded.model), arguments.settings(film));
    let mut studio =
        Studio { arguments, simulation, renderer, framed: None, spent: Duration::ZERO, interrupted: false };
    let time = arguments.time.unwrap_or(if film { 2.0 } else { 0.0 });
    let begin = studio.simulation.state().time;
    let steps = clock::steps("--time", time, studio.simulation.timestep())?;
    let frames = match form {
        Form::Picture => {
            let progress = output::progress(steps as u64, "steps");
            studio.advance_to(begin + time, &progress)?;
            progress.finish_and_clear();
            let picture = studio.take()?;
            save(arguments, |out| write_png(&picture, out))?;
            1
        }
        Form::Mp4 => {
            let mut film = Film::new(arguments.size, arguments.rate())?;
            studio.roll(begin, time, |frame| film.add(&frame).map_err(CliError::from))?;
            save(arguments, |out| film.write(out))?;
            film.len()
        }
        Form::AnimatedPng => {
            let mut frames = Vec::new();
            studio.roll(begin, time, |frame| {
                frames.push(frame);
                Ok(())
            })?;
            save(arguments, |out| write_animated_png(&frames, arguments.rate(), out))?;
            frames.len()
        }
    };
    let rendered = Rendered {
        out: (&arguments.out).into(),
        model: loaded.model.name.clone(),
        width: arguments.size[0],
        height: arguments.size[1],
        frames,
        time: studio.simulation.state().time,
        seconds_per_frame: studio.spent.as_secs_f64() / frames as f64,
    };
    output::print_result(&rendered, arguments.json, text);
    Ok(match studio.simulation.summary().missed_steps {
        _ if studio.interrupted => Exit::Interrupted,
        0 => Exit::Success,
        _ => Exit::NotSolved,
    })
}

/// The simulation before the camera.
struct Studio<'a> {
    arguments: &'a Arguments,
    simulation: Simulation,
    renderer: Renderer,
    /// The view that the first frame fills.
    framed: Option<View>,
    /// Wall time of pictures.
    spent: Duration,
    /// Whether a signal ended the film before its time.
    interrupted: bool,
}

impl Studio<'_> {
    /// Steps up to a time; the last step begins before it.
    fn advance_to(&mut self, time: f64, progress: &ProgressBar) -> Result<(), CliError> {
        let step = self.simulation.timestep();
        while self.simulation.state().time + 0.5 * step < time {
            let report = self.simulation.step().map_err(|source| CliError::Step { time, source })?;
            if !report.advanced() {
                return Err(CliError::NoFurther { time: self.simulation.state().time });
            }
            progress.inc(1);
        }
        Ok(())
    }

    /// Gives every frame of a film of `time` seconds, or those up to a signal.
    fn roll(
        &mut self,
        begin: f64,
        time: f64,
        mut keep: impl FnMut(Picture) -> Result<(), CliError>,
    ) -> Result<(), CliError> {
        let rate = self.arguments.rate();
        let count = (time * rate).round();
        if count >= f64::from(MOST_FRAMES) {
            return Err(CliError::TooManyFrames { time, rate, most: MOST_FRAMES });
        }
        let count = count as usize;
        let progress = output::progress(count as u64, "frames");
        let interrupt = Interrupt::listen();
        for k in 0..=count {
            if k > 0 && interrupt.came() {
                self.interrupted = true;
                break;
            }
            self.advance_to(begin + k as f64 / rate, &ProgressBar::hidden())?;
            keep(self.take()?)?;
            progress.set_position(k as u64);
        }
        progress.finish_and_clear();
        Ok(())
    }

    fn take(&mut self) -> Result<Picture, CliError> {
        let begin = Instant::now();
        self.renderer.place_with(&self.simulation.state().q, &self.simulation.input)?;
        let [width, height] = self.arguments.size;
        let view = match &self.arguments.camera {
            Some(name) => self.renderer.camera(name)?,
            None => {
                let [azimuth, elevation] = self.arguments.look;
                let aspect = width as f64 / height as f64;
                *self.framed.get_or_insert_with(|| self.renderer.framing_from(azimuth, elevation, aspect))
            }
        };
        let picture = self.renderer.picture(&view, self.arguments.size)?;
        self.spent += begin.elapsed();
        Ok(picture)
    }
}

/// Writes the file, whole or not at all.
fn save(arguments: &Arguments, write: impl FnOnce(&mut Vec<u8>) -> Result<(), RenderError>) -> Result<(), CliError> {
    let mut bytes = Vec::new();
    write(&mut bytes)?;
    let path = &arguments.out;
    signorini_files::write(path, bytes).map_err(|source| CliError::Write { path: path.clone(), source })
}

fn text(rendered: &Rendered) -> String {
    let Rendered { out, width, height, frames, time, seconds_per_frame, .. } = rendered;
    let what = if *frames == 1 { "picture".to_owned() } else { format!("{frames} frames") };
    let milliseconds = 1e3 * seconds_per_frame;
    format!("{}: {what} of {width} x {height} up to t = {time:.3} s, {milliseconds:.0} ms each\n", out.display())
}

/// What kind of file is written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Picture,
    Mp4,
    AnimatedPng,
}

impl Form {
    fn of(path: &Path) -> Result<Self, CliError> {
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        match ending.as_deref() {
            Some("png") => Ok(Self::Picture),
            Some("mp4") => Ok(Self::Mp4),
            Some("apng") => Ok(Self::AnimatedPng),
            _ => Err(CliError::PictureEnding { path: path.to_owned() }),
        }
    }
}

fn size(text: &str) -> Result<[usize; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|n| (1..=signorini::render::LARGEST).contains(n));
    let sides = text.split_once(['x', 'X', '×']).and_then(|(width, height)| Some([side(width)?, side(height)?]));
    sides.ok_or_else(|| format!("must be WIDTHxHEIGHT, each 1 to {}", signorini::render::LARGEST))
}

fn angles(text: &str) -> Result<[f64; 2], String> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let both = text.split_once(',').and_then(|(azimuth, elevation)| Some([number(azimuth)?, number(elevation)?]));
    both.ok_or_else(|| "must be two angles in degrees, as 120,-20".into())
}

fn not_negative(text: &str) -> Result<f64, String> {
    text.parse::<f64>().ok().filter(|x| *x >= 0.0 && x.is_finite()).ok_or_else(|| "must be a number from 0 on".into())
}
