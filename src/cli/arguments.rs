//! What can be typed.

use clap::builder::styling::{AnsiColor, Styles};
use clap::{Args, ColorChoice, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

/// Prepare, run and check discrete element simulations: one scene file in;
/// random grains, clumps, a packing, a run of its own DEM, LIGGGHTS, YADE and LAMMPS decks,
/// and a report of how far the solvers agree out.
#[derive(Debug, Parser)]
#[command(name = "riprap", version, styles = STYLES, max_term_width = 100, after_help = "Examples:
  riprap demo                       the main job on a built-in scene
  riprap new spheres-box work       a scene to start from
  riprap check work/scene.toml      judge it without running anything
  riprap run work/scene.toml        grains, clumps, packing, DEM
  riprap compare work/scene.toml    the same in the installed solvers, with a report

Exit codes: 0 done; 1 the work failed or a comparison is outside its tolerance;
2 the input is wrong; 3 an outside solver is missing or failed; 130 stopped by Ctrl-C or a signal.")]
pub struct Arguments {
    /// Say only what went wrong.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Say more.
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Print one JSON object on standard output and nothing else there.
    #[arg(long, global = true)]
    pub json: bool,
    /// Threads to use (default: all cores). Results do not depend on it.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Colours in messages; NO_COLOR is heeded.
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    pub color: ColorChoice,
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
}

/// Verbs.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Do the main job on a built-in scene: grains to report, with the solvers that are installed.
    Demo(Demo),
    /// Copy a built-in scene to start from.
    New(New),
    /// List methods with their keys, sources and what they do.
    List(List),
    /// Read and judge a scene; run nothing.
    Check(Check),
    /// Make the random particles of a scene as STL.
    Generate(Generate),
    /// Reproduce the particles of a scene, or one mesh, as clumps of spheres.
    Reproduce(Reproduce),
    /// Pack the particles of a scene.
    Pack(SceneOnly),
    /// Run all stages up to and including riprap's own DEM.
    Run(Run),
    /// Write input decks for outside solvers.
    Export(Export),
    /// Run a scene here and in the installed solvers, compare, write the report.
    Compare(Compare),
    /// Study error against run time: tables, charts, CSV and a page.
    Study(Study),
    /// Do many cases of one scene: a grid, a list or a Latin hypercube over any keys.
    Sweep(Sweep),
    /// Measure meshes, clumps, packings and states.
    Measure(Measure),
    /// Convert between all formats that riprap knows, by extension.
    Convert(Convert),
    /// Draw a mesh, clump, packing or state as a PNG picture.
    View(View),
    /// Print shell completions.
    Completions {
        /// Shell.
        shell: clap_complete::Shell,
    },
    /// Print the manual page.
    Man,
}

/// `riprap demo`.
#[derive(Debug, Args)]
pub struct Demo {
    /// Folder for the scene and its results.
    #[arg(short, long, value_name = "DIR", default_value = "riprap-demo")]
    pub output: PathBuf,
}

/// `riprap new`.
#[derive(Debug, Args)]
pub struct New {
    /// Name of the scene, see `riprap list scenes`.
    pub scene: String,
    /// Folder to put it in (default: a folder of that name).
    pub folder: Option<PathBuf>,
}

/// `riprap list`.
#[derive(Debug, Args)]
pub struct List {
    /// What to list (default: everything).
    pub what: Option<Kind>,
    /// With `scenes`: print the JSON schema of scene files, for editors.
    #[arg(long)]
    pub schema: bool,
}

/// What can be listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// Built-in scenes.
    Scenes,
    /// Particle shapes.
    Shapes,
    /// Clump methods.
    Clumps,
    /// Packing methods.
    Packings,
    /// Measures of packings and runs.
    Measures,
    /// Contact laws and schemes.
    Contacts,
    /// Outside solvers, and whether they are installed.
    Solvers,
    /// File formats.
    Formats,
    /// Studies of error against run time.
    Studies,
}

/// `riprap check`.
#[derive(Debug, Args)]
pub struct Check {
    /// Scene file (TOML).
    pub scene: PathBuf,
    /// Nothing is written; taken so that it need not be taken out of a command line.
    #[arg(short, long, value_name = "DIR", hide = true)]
    pub output: Option<PathBuf>,
}

/// `riprap generate`.
#[derive(Debug, Args)]
pub struct Generate {
    /// Scene and output folder.
    #[command(flatten)]
    pub scene: SceneOnly,
    /// Write the first draw of each grain as it comes to as-drawn/, valid grain or
    /// not, and say why not; make no grains.
    #[arg(long)]
    pub as_drawn: bool,
}

/// A scene and where its results go.
#[derive(Debug, Args)]
pub struct SceneOnly {
    /// Scene file (TOML).
    pub scene: PathBuf,
    /// Output folder (default: NAME.out beside the scene).
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// `riprap reproduce`.
#[derive(Debug, Args)]
pub struct Reproduce {
    /// Scene file, or an STL, PLY or OBJ mesh.
    pub input: PathBuf,
    /// Output folder of a scene, or CSV file for the clump of a mesh.
    #[arg(short, long, value_name = "PATH")]
    pub output: Option<PathBuf>,
    /// For a mesh: method, see `riprap list clumps`.
    #[arg(long, value_name = "KEY", default_value = "fitted")]
    pub method: String,
    /// For a mesh: largest number of spheres.
    #[arg(long, value_name = "N", conflicts_with = "error", value_parser = clap::value_parser!(u32).range(1..))]
    pub spheres: Option<u32>,
    /// For a mesh: RMS surface distance to reach, as a fraction of the equivalent diameter.
    #[arg(long, value_name = "E")]
    pub error: Option<f64>,
}

/// `riprap run`.
#[derive(Debug, Args)]
pub struct Run {
    /// Scene and output folder.
    #[command(flatten)]
    pub scene: SceneOnly,
    /// Go on from the last checkpoint of an interrupted run, bit for bit.
    #[arg(long)]
    pub resume: bool,
}

/// `riprap export`.
#[derive(Debug, Args)]
pub struct Export {
    /// Scene and output folder.
    #[command(flatten)]
    pub scene: SceneOnly,
    /// Solvers to write decks for, separated by commas: liggghts, yade, lammps.
    #[arg(long, value_name = "SOLVERS", value_delimiter = ',', default_value = "liggghts,yade")]
    pub to: Vec<String>,
    /// MPI ranks in the run scripts of LIGGGHTS and LAMMPS. YADE runs on one thread: with more its last digits vary.
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..))]
    pub ranks: u16,
    /// Processor grid of LIGGGHTS and LAMMPS, for example 2,2,1; its product is the number of ranks
    /// (default: they choose).
    #[arg(long, value_name = "X,Y,Z", value_parser = grid)]
    pub processors: Option<[usize; 3]>,
    /// Write a batch-queue script (job.slurm) too.
    #[arg(long)]
    pub queue: bool,
}

/// Three counts separated by commas.
fn grid(text: &str) -> Result<[usize; 3], String> {
    let counts: Result<Vec<usize>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    counts
        .ok()
        .and_then(|counts| <[usize; 3]>::try_from(counts).ok())
        .filter(|counts| counts.iter().all(|count| *count > 0))
        .ok_or_else(|| "three whole numbers greater than 0, for example 2,2,1".to_owned())
}

/// `riprap compare`.
#[derive(Debug, Args)]
pub struct Compare {
    /// Scene file (TOML); none with --all.
    #[arg(required_unless_present = "all", conflicts_with = "all")]
    pub scene: Option<PathBuf>,
    /// Output folder (default: NAME.out beside the scene; with --all: riprap-matrix).
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Solvers to compare with, separated by commas (default: those installed).
    #[arg(long, value_name = "SOLVERS", value_delimiter = ',')]
    pub with: Vec<String>,
    /// Run the built-in comparison matrix instead of a scene: some forty cases, each with its
    /// scene, tolerance and reason, and one page of verdicts.
    #[arg(long)]
    pub all: bool,
    /// With --all: only cases whose key holds this text.
    #[arg(long, value_name = "TEXT", requires = "all")]
    pub only: Option<String>,
    /// Start all codes again from the same state every N steps of the scene and compare where
    /// each segment ends, instead of one run that chaos parts.
    #[arg(long, value_name = "N", conflicts_with = "all", value_parser = clap::value_parser!(u64).range(1..))]
    pub lock_step: Option<u64>,
}

/// `riprap study`.
#[derive(Debug, Args)]
pub struct Study {
    /// What to study: see `riprap list studies`.
    pub what: String,
    /// Folder for tables, charts and page (default: study-WHAT).
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Fewer points: seconds to minutes instead of minutes to half an hour (`clump`: five minutes of CPU).
    #[arg(long)]
    pub quick: bool,
    /// Study clump: leave out what the error of a clump costs in a DEM run.
    #[arg(long)]
    pub without_dem: bool,
}

/// `riprap sweep`.
#[derive(Debug, Args)]
pub struct Sweep {
    /// Sweep file (TOML).
    pub sweep: PathBuf,
    /// Output folder (default: NAME.out beside the sweep file).
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Cases at a time (default: as many as threads).
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Go on with an interrupted sweep; cases that failed are tried again.
    #[arg(long)]
    pub resume: bool,
    /// Write the scenes of all cases and a job array for a cluster; run nothing.
    #[arg(long, conflicts_with = "resume")]
    pub write_only: bool,
}

/// `riprap measure`.
#[derive(Debug, Args)]
pub struct Measure {
    /// Meshes (STL, PLY, OBJ), clumps, packings, states, dumps.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Solid that the files' spheres stand for, in the same frame: gives their errors against it.
    #[arg(long, value_name = "MESH")]
    pub against: Option<PathBuf>,
    /// Middle of a measuring sphere, m; may be given several times, each with a --radius.
    #[arg(long, value_name = "X,Y,Z", value_parser = numbers::<3>, requires = "radius", allow_hyphen_values = true)]
    pub at: Vec<[f64; 3]>,
    /// Its radius, m; one for all, or one for each.
    #[arg(long, value_name = "R", requires = "at")]
    pub radius: Vec<f64>,
    /// Measure spheres in layers along the last axis, with radial distribution and stress.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub layers: Option<u16>,
    /// Local measures: measuring spheres of this radius, m, side by side through the container.
    #[arg(long, value_name = "R")]
    pub field: Option<f64>,
    /// Container of the spheres, m (default: the box in the file, or that around all spheres).
    #[arg(long = "box", value_name = "XLO,YLO,ZLO,XHI,YHI,ZHI", value_parser = numbers::<6>, allow_hyphen_values = true)]
    pub room: Option<[f64; 6]>,
    /// Axes along which the container repeats, for example xy.
    #[arg(long, value_name = "AXES")]
    pub periodic: Option<String>,
    /// Discs in the x-y plane instead of spheres.
    #[arg(long)]
    pub discs: bool,
    /// Gap up to which bodies touch, m (default: 1e-6 of the median radius).
    #[arg(long, value_name = "GAP")]
    pub gap: Option<f64>,
    /// Contact forces for the stress, as run/contacts.csv.
    #[arg(long, value_name = "FILE")]
    pub contacts: Option<PathBuf>,
    /// Stiffness of springs, N/m: contact forces from overlaps, where there is no file of them.
    #[arg(long, value_name = "KN", conflicts_with = "contacts")]
    pub stiffness: Option<f64>,
    /// Folder for tables (CSV), charts (SVG) and a page of all measures of spheres.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Numbers separated by commas.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let all: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    all.ok()
        .and_then(|all| <[f64; N]>::try_from(all).ok())
        .filter(|all| all.iter().all(|x| x.is_finite()))
        .ok_or_else(|| format!("{N} finite numbers with commas between"))
}

/// `riprap convert`.
#[derive(Debug, Args)]
pub struct Convert {
    /// File to read.
    pub input: PathBuf,
    /// File to write; the extension chooses the format, see `riprap list formats`.
    pub output: PathBuf,
}

/// `riprap view`.
#[derive(Debug, Args)]
pub struct View {
    /// Meshes, clumps, packings or states, drawn side by side; states to one scale.
    #[arg(required = true, value_name = "FILE")]
    pub inputs: Vec<PathBuf>,
    /// PNG file to write: NAME.png.
    #[arg(short, long, value_name = "PNG")]
    pub output: PathBuf,
    /// Width of the picture of each file, pixels.
    #[arg(long, value_name = "PIXELS", default_value_t = 800, value_parser = clap::value_parser!(u32).range(16..=4096))]
    pub width: u32,
    /// Height of the picture of each file, pixels.
    #[arg(long, value_name = "PIXELS", default_value_t = 600, value_parser = clap::value_parser!(u32).range(16..=4096))]
    pub height: u32,
}
