//! A recording as timed messages in an MCAP file.

mod messages;
mod scene;
mod schemas;
mod stamp;

use std::collections::BTreeMap;

use std::path::Path;

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};
use serde_json::Value;
use signorini_files::WholeFile;
use signorini_recording::{Frame, Header};

use super::parts::{create, finish, force};
use crate::{FrameSource, ReplayError};
use messages::{LONGEST_ARROW, norm};
use stamp::Stamp;

/// Writes a recording as an MCAP file with JSON messages, for Foxglove and whatever else reads MCAP.
///
/// | topic | schema | content |
/// |---|---|---|
/// | `/tf` | foxglove.FrameTransforms | poses of all bodies in the world |
/// | `/scene` | foxglove.SceneUpdate | the shapes, once, fixed to their bodies |
/// | `/contact_forces` | foxglove.SceneUpdate | an arrow for each closed contact: the mean force of the step on the second body |
/// | `/contacts` | signorini.Contacts | every contact: bodies, geoms, point, normal, gap, friction, impulse, force, mode |
/// | `/certificate` | signorini.Certificate | residuals, the largest of them, status, solver iterations |
/// | `/state` | signorini.State | step, q, v, energies, control |
///
/// Times are those of the simulation, from 0 on in ns. Metadata `recording` holds model, hash, generator, method, time step,
/// tolerance, and what an arrow of 1 m stands for. Numbers that are not finite are `null`.
///
/// # Errors
/// [`ReplayError::Write`], [`ReplayError::Mcap`], and [`ReplayError::Recording`] if a frame cannot be read.
pub fn write_mcap(frames: &mut impl FrameSource, path: &Path) -> Result<(), ReplayError> {
    let header = frames.header().clone();
    let mut largest = 0.0_f64;
    frames.visit(&mut |_, frame| {
        let forces = frame.contacts.iter().map(|contact| norm(force(contact, header.timestep)));
        largest = forces.filter(|f| f.is_finite()).fold(largest, f64::max);
        Ok(())
    })?;
    let fail = |source| match source {
        // Its own text keeps what the system says to itself.
        McapError::Io(source) => ReplayError::Write { path: path.to_owned(), source },
        source => ReplayError::Mcap { path: path.to_owned(), source: Box::new(source) },
    };
    let scale = if largest > 0.0 { LONGEST_ARROW / largest } else { 0.0 };
    let mut messages = Messages::create(create(path)?, header, scale).map_err(fail)?;
    frames.visit(&mut |_, frame| messages.push(frame).map_err(fail))?;
    finish(messages.finish().map_err(fail)?, path)
}

/// The file while it grows.
struct Messages {
    writer: Writer<WholeFile>,
    header: Header,
    /// Metres of arrow per newton.
    scale: f64,
    frames: u32,
    channels: [u16; 6],
}

/// The channels, in the order of [`Messages::channels`]: topic and schema.
const CHANNELS: [(&str, &str); 6] = [
    ("/tf", schemas::FRAME_TRANSFORMS),
    ("/scene", schemas::SCENE_UPDATE),
    ("/contact_forces", schemas::SCENE_UPDATE),
    ("/contacts", schemas::CONTACTS),
    ("/certificate", schemas::CERTIFICATE),
    ("/state", schemas::STATE),
];

impl Messages {
    fn create(output: WholeFile, header: Header, scale: f64) -> Result<Self, McapError> {
        let library = format!("signorini {}", env!("CARGO_PKG_VERSION"));
        let mut writer = WriteOptions::new().compression(None).library(library).create(output)?;
        let mut channels = [0; 6];
        for (id, (topic, schema)) in channels.iter_mut().zip(CHANNELS) {
            let text = schemas::schema(schema).to_string();
            let schema = writer.add_schema(schema, "jsonschema", text.as_bytes())?;
            *id = writer.add_channel(schema, topic, "json", &BTreeMap::new())?;
        }
        writer.write_metadata(&mcap::records::Metadata {
            name: "recording".into(),
            metadata: messages::metadata(&header, scale),
        })?;
        Ok(Self { writer, header, scale, frames: 0, channels })
    }

    fn push(&mut self, frame: &Frame) -> Result<(), McapError> {
        let stamp = Stamp::of(frame.time);
        if self.frames == 0 {
            self.write(1, stamp, &scene::shapes(&self.header, stamp))?;
        }
        let messages = [
            (0, messages::transforms(&self.header, frame, stamp)),
            (2, scene::forces(&self.header, frame, stamp, self.scale)),
            (3, messages::contacts(&self.header, frame, stamp)),
            (4, messages::certificate(frame, stamp)),
            (5, messages::state(frame, stamp)),
        ];
        for (channel, message) in messages {
            self.write(channel, stamp, &message)?;
        }
        self.frames += 1;
        Ok(())
    }

    fn write(&mut self, channel: usize, stamp: Stamp, message: &Value) -> Result<(), McapError> {
        let (channel_id, time) = (self.channels[channel], stamp.nanoseconds());
        let header = MessageHeader { channel_id, sequence: self.frames, log_time: time, publish_time: time };
        self.writer.write_to_known_channel(&header, message.to_string().as_bytes())
    }

    fn finish(mut self) -> Result<WholeFile, McapError> {
        self.writer.finish()?;
        Ok(self.writer.into_inner())
    }
}
