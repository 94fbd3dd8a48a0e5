//! Parameters of the tossed cube from recordings, by the derivatives of its steps.

use clap::ValueEnum;
use signorini::derivatives::ScalarParameter;
use signorini::derivatives::identification::{
    Identification, IdentificationError, IdentificationSettings, Recording, Unknown, identify,
};
use signorini::multibody::{BodyId, GeomId, Model, State};
use signorini::{InfeasiblePolicy, Settings};
use signorini_testkit::Random;

use crate::tosses::{HALF_SIDE, INERTIA, Protocol, SAMPLE_RATE, Toss, start_state};

/// The unit of differences, as a part of the cube's width and in rad: how far the best parameters leave a toss. Priors are weighed against it.
const UNIT: f64 = 0.1;
/// Differences from which on they count by their size, in that unit: the noise of the recording is a tenth of the unit.
const OUTLIER: f64 = 0.2;

/// Steps of the method from the best of several starts.
const COARSE: usize = 2;

/// What of the cube is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Quantity {
    /// Coefficient of friction of cube and board.
    Friction,
    /// Coefficient of restitution of both.
    Restitution,
    /// Moment of inertia about all axes.
    Inertia,
    /// Half the side.
    Size,
    /// The three coordinates of the centre of mass.
    Center,
}

/// The model's numbers for it, as unknowns; what a ruler and a pair of scales tell is known before to about a percent.
fn unknowns_of(quantity: Quantity) -> Vec<Unknown> {
    let (cube, geoms) = (BodyId(1), [GeomId(0), GeomId(1)]);
    let both = |of: fn(GeomId) -> ScalarParameter| geoms.map(|id| (of(id), 1.0)).to_vec();
    match quantity {
        Quantity::Friction => {
            vec![Unknown::new("friction", both(ScalarParameter::Friction)).with_bounds([0.02, 0.6])]
        }
        Quantity::Restitution => {
            vec![Unknown::new("restitution", both(ScalarParameter::Restitution)).with_bounds([0.0, 0.5])]
        }
        Quantity::Inertia => {
            let entries = (0..3).map(|a| (ScalarParameter::Inertia(cube, [a, a]), 1.0)).collect();
            vec![Unknown::new("inertia", entries).with_bounds([0.0004, 0.0016]).with_prior(INERTIA, 0.05 * INERTIA)]
        }
        Quantity::Size => {
            let sizes = (0..3).map(|a| (ScalarParameter::GeomSize(geoms[0], a), 1.0)).collect();
            let unknown = Unknown::new("half side", sizes).with_bounds([0.9 * HALF_SIDE, 1.1 * HALF_SIDE]);
            vec![unknown.with_prior(HALF_SIDE, 0.01 * HALF_SIDE)]
        }
        Quantity::Center => (0..3)
            .map(|a| {
                let name = ["centre x", "centre y", "centre z"][a];
                let unknown = Unknown::new(name, vec![(ScalarParameter::CenterOfMass(cube, a), 1.0)]);
                unknown.with_bounds([-0.005, 0.005]).with_prior(0.0, 0.01 * HALF_SIDE)
            })
            .collect(),
    }
}

/// How the parameters are looked for.
#[derive(Clone, Debug)]
pub struct Fit {
    /// What is looked for.
    pub quantities: Vec<Quantity>,
    /// Friction directions.
    pub directions: usize,
    /// Steps between two samples.
    pub substeps: usize,
    /// What is done to the recording.
    pub protocol: Protocol,
    /// Starts within the bounds.
    pub starts: usize,
    /// Samples of the windows in which trajectories are predicted, one for each stage; 0 for whole tosses.
    pub windows: Vec<usize>,
    /// Steps of the method in each stage at most.
    pub iterations: usize,
    /// Sets drawn for the covariance of the last stage; the spread of slopes where it is 0.
    pub draws: usize,
    /// Whether each step of the method is printed.
    pub is_told: bool,
}

impl Fit {
    /// Fits a model to tosses, stage by stage; several starts are those of the friction, on which most depends, alone before anything else.
    ///
    /// # Errors
    /// [`IdentificationError`] of any.
    pub fn run(&self, model: &Model, tosses: &[Toss]) -> Result<Identification, IdentificationError> {
        let (last, others) = self.windows.split_last().unwrap_or((&0, &[]));
        let mut model = model.clone();
        let is_one_stage = self.quantities == [Quantity::Friction] && others.is_empty();
        if self.starts > 0 && !is_one_stage {
            let coarse = Self { quantities: vec![Quantity::Friction], iterations: COARSE, ..self.clone() };
            model = coarse.stage(&model, tosses, *last, (self.starts, 0))?.model;
        }
        for window in others {
            model = self.stage(&model, tosses, *window, (0, 0))?.model;
        }
        self.stage(&model, tosses, *last, (if is_one_stage { self.starts } else { 0 }, self.draws))
    }

    /// The standard deviation of each unknown over `draws` sets of tosses drawn from those at hand, each fitted from `model` on by the last stage.
    ///
    /// # Errors
    /// [`IdentificationError`] of any.
    pub fn bootstrap(&self, model: &Model, tosses: &[Toss], draws: usize) -> Result<Vec<f64>, IdentificationError> {
        let mut random = Random::new(1);
        let mut found = Vec::new();
        for _ in 0..draws {
            let drawn: Vec<Toss> = (0..tosses.len()).map(|_| tosses[random.below(tosses.len())].clone()).collect();
            found.push(self.stage(model, &drawn, *self.windows.last().unwrap_or(&0), (0, 0))?.values);
        }
        let n = found.len() as f64;
        let mean = |i: usize| found.iter().map(|values| values[i]).sum::<f64>() / n;
        let variance = |i: usize| found.iter().map(|values| (values[i] - mean(i)).powi(2)).sum::<f64>() / (n - 1.0);
        Ok((0..found.first().map_or(0, Vec::len)).map(|i| variance(i).sqrt()).collect())
    }

    fn stage(
        &self,
        model: &Model,
        tosses: &[Toss],
        window: usize,
        (starts, draws): (usize, usize),
    ) -> Result<Identification, IdentificationError> {
        let settings = Settings::default().with_directions(self.directions).with_infeasible(InfeasiblePolicy::ClipGaps);
        let recordings: Vec<Recording> = tosses.iter().map(|toss| self.recording(toss)).collect();
        let unknowns: Vec<Unknown> = self.quantities.iter().flat_map(|&quantity| unknowns_of(quantity)).collect();
        let mut asked = IdentificationSettings::new(1.0 / SAMPLE_RATE);
        (asked.substeps, asked.window, asked.starts, asked.draws) = (self.substeps, window, starts, draws);
        (asked.outlier, asked.equal_recordings, asked.iterations) = (OUTLIER, true, self.iterations);
        let per_width = 1.0 / (2.0 * HALF_SIDE * UNIT);
        asked.weights = [[per_width; 3], [1.0 / UNIT; 3]].concat();
        identify(model, &settings, &recordings, &unknowns, &asked, |progress| {
            if self.is_told {
                println!("  {}: objective {:.5} at {:.6?}", progress.iteration, progress.objective, progress.values);
            }
            true
        })
    }

    fn recording(&self, toss: &Toss) -> Recording {
        Recording::new(
            toss.samples.iter().map(|row| start_state(row, self.protocol, self.substeps)).collect::<Vec<State>>(),
        )
    }
}
