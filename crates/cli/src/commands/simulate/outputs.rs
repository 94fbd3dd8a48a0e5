//! Recording and report, written while the run goes on.

use std::fs::File;
use std::path::{Path, PathBuf};

use signorini::multibody::State;
use signorini::recording::report::{ReportBuilder, ReportSettings};
use signorini::recording::{Ending, Frame, Header, Writer};
use signorini::{Simulation, StepReport, frame_into, last_frame_into, recording_header, step_solution_into};
use signorini_files::WholeFile;

use crate::error::CliError;
use crate::loading::Loaded;

/// Where the frames of a run go.
pub struct Outputs {
    writer: Option<Writer<File>>,
    report: Option<Report>,
    frame: Frame,
    /// State at the beginning of the step.
    before: State,
}

struct Report {
    path: PathBuf,
    builder: ReportBuilder,
}

impl Outputs {
    /// Creates the files.
    pub fn create(
        simulation: &Simulation,
        record: Option<&Path>,
        report: Option<&Path>,
        loaded: &Loaded,
    ) -> Result<Self, CliError> {
        let source = Some(loaded.file.clone());
        let header =
            Header { source, ..recording_header(simulation.model(), simulation.settings(), simulation.workspace()) };
        let writer = record.map(|path| Writer::create(path, header.clone())).transpose()?;
        let report = report.map(|path| -> Result<Report, CliError> {
            // A bad path shows before the run.
            drop(WholeFile::create(path).map_err(|source| CliError::Write { path: path.to_owned(), source })?);
            let notes = loaded.notes();
            let builder = ReportBuilder::new(header.clone(), ReportSettings::default().with_notes(notes))?;
            Ok(Report { path: path.to_owned(), builder })
        });
        let (report, before) = (report.transpose()?, simulation.state().clone());
        Ok(Self { writer, report, frame: Frame::default(), before })
    }

    /// Time at the beginning of the step that comes next, s.
    pub fn time(&self) -> f64 {
        self.before.time
    }

    /// Adds the step just made.
    pub fn add(&mut self, index: u64, simulation: &Simulation, report: &StepReport) -> Result<(), CliError> {
        if self.writer.is_some() || self.report.is_some() {
            let workspace = simulation.workspace();
            frame_into(simulation.model(), index, &self.before, workspace, report, &mut self.frame);
            if let Some(writer) = &mut self.writer {
                step_solution_into(&simulation.input, workspace, report, &mut self.frame);
                writer.append(&self.frame)?;
            }
            if let Some(report) = &mut self.report {
                report.builder.push(&self.frame)?;
            }
        }
        self.before.clone_from(simulation.state());
        Ok(())
    }

    /// Adds the state that the run ended in to the recording. The report ends with the last step instead, so that its
    /// curves have no point without contacts at their end.
    pub fn add_last_state(&mut self, index: u64, simulation: &Simulation) -> Result<(), CliError> {
        if let Some(writer) = &mut self.writer {
            last_frame_into(simulation.model(), index, simulation.state(), &simulation.input, &mut self.frame);
            writer.append(&self.frame)?;
        }
        Ok(())
    }

    /// Ends the recording and writes the report.
    pub fn finish(self, reason: &str) -> Result<(), CliError> {
        if let Some(writer) = self.writer {
            writer.finish(reason)?;
        }
        if let Some(Report { path, builder }) = self.report {
            builder.write_file(path, &Ending::Finished { reason: reason.to_owned() })?;
        }
        Ok(())
    }
}
