//! `signorini make`.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};
use serde::Serialize;
use signorini_generate::{Arch, Heap, Pallet, Rough, Shapes, Stack, Stairs, Terrain, Wall};

use crate::args::length;
use crate::error::CliError;
use crate::exit::Exit;
use crate::output;
use crate::results::FileName;

const HELP: &str = "\
The file is MJCF and needs no other file. The same numbers and the same --seed give the same file.

Examples:
  signorini make heap --count 50 --shapes mixed --seed 3 --out heap.xml
  signorini make arch --count 21 --thickness 0.12 --out arch.xml
  signorini make terrain --image hills.png --height 0.5 --objects 20 --out hills.xml
  signorini simulate heap.xml --report heap.html";

/// Arguments of `make`.
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// What to make.
    #[command(subcommand)]
    pub kind: Kind,
    /// The file to write; without one the text is printed.
    #[arg(long, value_name = "FILE.xml", global = true)]
    pub out: Option<PathBuf>,
    /// Which of all worlds of these numbers.
    #[arg(long, value_name = "N", default_value_t = 0, global = true)]
    pub seed: u64,
    /// Coefficient of friction. [default: one that fits]
    #[arg(long, value_name = "MU", global = true)]
    pub friction: Option<f64>,
    /// Print one JSON object about the file.
    #[arg(long, global = true, requires = "out")]
    pub json: bool,
}

/// Worlds that can be made.
#[derive(Debug, Subcommand)]
pub enum Kind {
    /// Random objects that fall into a bin.
    Heap {
        /// Number of objects.
        #[arg(long, value_name = "N", default_value_t = 30)]
        count: usize,
        /// What they are.
        #[arg(long, value_name = "WHAT", value_enum, default_value_t = ShapesName::Boxes)]
        shapes: ShapesName,
        /// About their radius, m.
        #[arg(long, value_name = "M", default_value_t = 0.05, value_parser = length)]
        radius: f64,
        /// No walls around.
        #[arg(long)]
        open: bool,
    },
    /// Cubes on top of each other.
    Stack {
        /// Number of cubes.
        #[arg(long, value_name = "N", default_value_t = 10)]
        count: usize,
        /// Length of an edge, m.
        #[arg(long, value_name = "M", default_value_t = 0.2, value_parser = length)]
        size: f64,
        /// Most that a cube is off the one below, as a share of its length.
        #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
        offset: f64,
    },
    /// Boxes in layers on a pallet.
    Pallet {
        /// Number of layers.
        #[arg(long, value_name = "N", default_value_t = 4)]
        layers: usize,
        /// The pallet is part of the floor.
        #[arg(long)]
        fixed: bool,
    },
    /// Bricks in running bond.
    Wall {
        /// Bricks in a course.
        #[arg(long, value_name = "N", default_value_t = 8)]
        columns: usize,
        /// Number of courses.
        #[arg(long, value_name = "N", default_value_t = 10)]
        courses: usize,
    },
    /// A half-circle of wedges.
    Arch {
        /// Number of wedges.
        #[arg(long, value_name = "N", default_value_t = 15)]
        count: usize,
        /// Thickness as a share of the mean radius.
        #[arg(long, value_name = "SHARE", default_value_t = 0.26)]
        thickness: f64,
    },
    /// Steps that lead up along x.
    Stairs {
        /// Number of steps.
        #[arg(long, value_name = "N", default_value_t = 8)]
        steps: usize,
        /// Height of a step, m.
        #[arg(long, value_name = "M", default_value_t = 0.17, value_parser = length)]
        rise: f64,
        /// Length of a step, m.
        #[arg(long, value_name = "M", default_value_t = 0.29, value_parser = length)]
        run: f64,
        /// Objects that fall onto the stairs.
        #[arg(long, value_name = "N", default_value_t = 0)]
        objects: usize,
    },
    /// Rough ground, a height field of random hills.
    Rough {
        /// Number of grid points along either side.
        #[arg(long, value_name = "N", default_value_t = 64)]
        points: usize,
        /// Length of a side, m.
        #[arg(long, value_name = "M", default_value_t = 6.0, value_parser = length)]
        size: f64,
        /// Height between the lowest and the highest point, m.
        #[arg(long, value_name = "M", default_value_t = 0.4, value_parser = length)]
        height: f64,
        /// 0 for smooth hills, up to 1.
        #[arg(long, value_name = "SHARE", default_value_t = 0.45)]
        roughness: f64,
        /// Objects that fall onto it.
        #[arg(long, value_name = "N", default_value_t = 0)]
        objects: usize,
    },
    /// A height field by the brightness of a picture.
    Terrain {
        /// The picture; white is highest.
        #[arg(long, value_name = "FILE.png")]
        image: PathBuf,
        /// Length along x, m; that along y follows from the picture. [default: 10 cm a pixel]
        #[arg(long, value_name = "M", value_parser = length)]
        size: Option<f64>,
        /// Height between black and white, m.
        #[arg(long, value_name = "M", default_value_t = 1.0, value_parser = length)]
        height: f64,
        /// Objects that fall onto it.
        #[arg(long, value_name = "N", default_value_t = 0)]
        objects: usize,
    },
}

/// What random objects are, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ShapesName {
    /// Boxes.
    Boxes,
    /// Balls.
    Spheres,
    /// Convex polyhedra.
    Stones,
    /// Of everything.
    Mixed,
}

/// What was made.
#[derive(Serialize)]
struct Made {
    out: FileName,
    bytes: usize,
    bodies: usize,
}

/// Makes the world.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    if let Kind::Terrain { image, .. } = &arguments.kind {
        output::keep_apart(&[image], &[("--out", arguments.out.as_deref())])?;
    }
    let text = text(arguments)?;
    let Some(out) = &arguments.out else {
        output::print(&text);
        return Ok(Exit::Success);
    };
    signorini_files::write(out, &text).map_err(|source| CliError::Write { path: out.clone(), source })?;
    let made = Made { out: out.into(), bytes: text.len(), bodies: text.matches("<freejoint").count() };
    output::print_result(&made, arguments.json, |made| {
        format!("{}: {} bodies, {} kB\n", made.out.display(), made.bodies, made.bytes.div_ceil(1000))
    });
    Ok(Exit::Success)
}

fn text(arguments: &Arguments) -> Result<String, CliError> {
    let (seed, friction) = (arguments.seed, arguments.friction);
    macro_rules! made {
        ($world:expr) => {{
            let mut world = $world;
            world.friction = friction.unwrap_or(world.friction);
            world.mjcf()?
        }};
    }
    Ok(match arguments.kind {
        Kind::Heap { count, shapes, radius, open } => {
            let shapes = match shapes {
                ShapesName::Boxes => Shapes::Boxes,
                ShapesName::Spheres => Shapes::Spheres,
                ShapesName::Stones => Shapes::Stones,
                ShapesName::Mixed => Shapes::Mixed,
            };
            made!(Heap::new(count).with_shapes(shapes).with_radius(radius).with_bin(!open).with_seed(seed))
        }
        Kind::Stack { count, size, offset } => {
            made!(Stack::new(count).with_size(size).with_offset(offset).with_seed(seed))
        }
        Kind::Pallet { layers, fixed } => made!(Pallet::new(layers).with_free(!fixed)),
        Kind::Wall { columns, courses } => made!(Wall::new(columns, courses)),
        Kind::Arch { count, thickness } => made!(Arch::new(count).with_thickness(thickness)),
        Kind::Stairs { steps, rise, run, objects } => {
            made!(Stairs::new(steps).with_rise(rise).with_run(run).with_objects(objects).with_seed(seed))
        }
        Kind::Rough { points, size, height, roughness, objects } => {
            let ground = Rough::new().with_points(points).with_size(size).with_height(height);
            made!(ground.with_roughness(roughness).with_objects(objects).with_seed(seed))
        }
        Kind::Terrain { ref image, size, height, objects } => {
            let mut terrain = terrain(image)?.with_height(height).with_objects(objects).with_seed(seed);
            if let Some(x) = size {
                let [own_x, own_y] = terrain.size;
                terrain.size = [x, x * own_y / own_x];
            }
            made!(terrain)
        }
    })
}

fn terrain(image: &Path) -> Result<Terrain, CliError> {
    let file = File::open(image).map_err(|source| CliError::Read { path: image.to_owned(), source })?;
    Terrain::of_picture(BufReader::new(file)).map_err(CliError::from)
}
