//! What was typed, as clap parses it. What it means is decided in `commands/`.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

pub use accuracy::{Accuracy, KnobName};
pub use bake::{Bake, BakeOnArg, Bounces, CodecArg, OrderArg, PatchesFromArg};
pub use bench::{Bench, BenchName};
pub use debug_view::DebugViewArg;
pub use deferred::{AccumulationArg, DeferredLightsArg, GbufferArg};
pub use effects::{EffectArgs, ShadowUpdateArg, TransparentBoundsArg, TransparentSortArg};
pub use gi::{GiArg, GiArgs, IterationArg, MatrixPathArg};
pub use light_lists::{AssignArg, ClusterBoundsArg, CullArg, DepthBoundsArg, DepthReduceArg};

mod accuracy;
mod bake;
mod bench;
mod debug_view;
mod deferred;
mod effects;
mod gi;
mod light_lists;

/// A Vulkan renderer for scenes with very many lights, every step explicit.
#[derive(Debug, Parser)]
#[command(name = "lampyris", version, about, args_conflicts_with_subcommands = true)]
pub struct Cli {
    /// What to do; without a command the built-in atrium is rendered to out.png.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// The commands that have landed.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Plan, draw and measure a scene, and write a PNG or EXR.
    Render(Render),
    /// Say which effects run and why, and list the barriers.
    Plan(PlanArgs),
    /// List drivers and, for each feature that can be used, what happens without it.
    Devices(Devices),
    /// Write a procedural scene as glTF, lights included; without a name, list them.
    Scene(SceneArgs),
    /// Compare two pictures.
    Diff(Diff),
    /// Check hard cases and equalities on the chosen driver.
    Check(Check),
    /// Bake the exchange of light between patches of a scene, for --gi radiosity:DIR.
    Bake(Bake),
    /// Run an experiment.
    Bench(Bench),
    /// Say what each knob costs: error against time and bytes, and the settings that no other beats.
    Accuracy(Accuracy),
}

/// Options that choose scene, light and camera.
#[derive(Debug, Clone, Args)]
pub struct Shared {
    /// Device or driver whose name contains this.
    #[arg(long, value_name = "SUBSTRING")]
    pub driver: Option<String>,
    /// Plan for the device's limits or for the least that the specification grants.
    #[arg(long, value_enum, default_value = "device")]
    pub limits: LimitsChoice,
    /// Picture size in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub size: (u32, u32),
    /// How to light.
    #[arg(long, value_enum, default_value = "auto")]
    pub technique: TechniqueChoice,
    /// Depth first, so that each pixel is shaded or stored once.
    #[arg(long, value_enum, default_value = "on")]
    pub prepass: OnOff,
    /// How light data is read.
    #[arg(long, value_enum, default_value = "auto")]
    pub light_fetch: FetchArg,
    /// Which lights a tile takes.
    #[arg(long, value_enum, default_value = "frustum-aabb")]
    pub cull: CullArg,
    /// What culling knows of a tile's depths [default: 2.5d with a pre-pass, off without].
    #[arg(long, value_enum)]
    pub depth_bounds: Option<DepthBoundsArg>,
    /// Pixels along each side of a tile.
    #[arg(long, value_name = "8|16|32|64", default_value = "16", value_parser = light_lists::parse_tile)]
    pub tile: u32,
    /// What bounds a cluster [default: explicit with a pre-pass, implicit without].
    #[arg(long, value_enum)]
    pub cluster_bounds: Option<ClusterBoundsArg>,
    /// Slices of clusters in each doubling of distance [default: about as deep as the tile is wide].
    #[arg(long, value_name = "1|2|4|...|64", value_parser = light_lists::parse_slices)]
    pub slices_per_octave: Option<u32>,
    /// Where clusters find the lights that may reach them.
    #[arg(long, value_enum, default_value = "auto")]
    pub assign: AssignArg,
    /// Tell clusters apart by where their normals point, and leave out lights behind them: clustered-deferred.
    #[arg(long)]
    pub cluster_normals: bool,
    /// How --technique deferred adds lights.
    #[arg(long, value_enum, default_value = "volumes")]
    pub deferred_lights: DeferredLightsArg,
    /// What the G-buffer of deferred techniques stores.
    #[arg(long, value_enum, default_value = "compact")]
    pub gbuffer: GbufferArg,
    /// Bits of each of a normal's two codes in the compact G-buffer.
    #[arg(long, value_name = "8|10|16", default_value = "16", value_parser = deferred::parse_normal_bits)]
    pub normal_bits: u32,
    /// What reduces the depths of a tile to its bounds [default: as the profile has it].
    #[arg(long, value_enum)]
    pub depth_reduce: Option<DepthReduceArg>,
    /// Pixels that a thread of tiled-deferred shades: four share what is read of each light [default: as the profile has it].
    #[arg(long, value_name = "1|4", value_parser = deferred::parse_pixels_a_thread)]
    pub pixels_a_thread: Option<u32>,
    /// What --deferred-lights volumes add in.
    #[arg(long, value_enum, default_value = "f32")]
    pub accumulation: AccumulationArg,
    /// Effects.
    #[command(flatten)]
    pub effects: EffectArgs,
    /// Bounced light.
    #[command(flatten)]
    pub bounced: GiArgs,
    /// Draw a small sphere of each light's colour where it stands.
    #[arg(long)]
    pub show_lights: bool,
    /// Reflection model.
    #[arg(long, value_enum, default_value = "gltf")]
    pub shading: ShadingArg,
    /// Ambient radiance, linear RGB.
    #[arg(long, value_name = "R,G,B", value_parser = parse_triple, allow_hyphen_values = true)]
    pub ambient: Option<[f64; 3]>,
    /// Distance law 1 / (C + L d + Q d^2) of point and spot lights [default: 0,0,1].
    #[arg(long, value_name = "C,L,Q", value_parser = parse_triple, allow_hyphen_values = true)]
    pub attenuation: Option<[f64; 3]>,
    /// Scatter N coloured point lights, in place of the scene's own.
    #[arg(long, value_name = "N")]
    pub lights: Option<u32>,
    /// Seed of the scattered lights.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub light_seed: u64,
    /// Range of every light in metres, or inf for no range and no window.
    #[arg(long, value_name = "R|inf", allow_hyphen_values = true)]
    pub light_range: Option<f64>,
    /// Cut-off from which ranges are solved [default: 5/256].
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    pub light_cutoff: Option<f64>,
    /// Camera of the scene, by name or index.
    #[arg(long, value_name = "NAME|INDEX", conflicts_with = "look_from")]
    pub camera: Option<String>,
    /// Eye.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_triple, allow_hyphen_values = true, requires = "look_at")]
    pub look_from: Option<[f64; 3]>,
    /// Point in the middle of the picture.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_triple, allow_hyphen_values = true, requires = "look_from")]
    pub look_at: Option<[f64; 3]>,
    /// Vertical field of view in degrees, with --look-from [default: 60].
    #[arg(long, value_name = "DEG", requires = "look_from", value_parser = parse_angle)]
    pub fov: Option<f64>,
    /// Draw an intermediate value instead of light, with a legend below the picture.
    #[arg(long, value_enum)]
    pub debug_view: Option<DebugViewArg>,
}

/// Arguments of `render`.
#[derive(Debug, Clone, Args)]
pub struct Render {
    /// A .gltf or .glb file, or builtin:NAME[:key=value,...].
    #[arg(default_value = "builtin:atrium")]
    pub scene: String,
    /// Where the picture goes: .png for display, .exr for scene-linear f32.
    #[arg(short, long, value_name = "FILE", default_value = "out.png")]
    pub output: PathBuf,
    /// Repeat the picture that FILE (a PNG or EXR of this program) says it is; of what else is typed only -o, --json, --validate and
    /// --driver count.
    #[arg(long, value_name = "FILE")]
    pub from: Option<PathBuf>,
    /// Scene, light and camera.
    #[command(flatten)]
    pub shared: Shared,
    /// Exposure in stops, or auto.
    #[arg(long, value_name = "EV|auto", default_value = "auto", allow_hyphen_values = true)]
    pub exposure: String,
    /// Curve from scene to display.
    #[arg(long, value_enum, default_value = "neutral")]
    pub tonemap: TonemapArg,
    /// Frames to time, after a warm-up of two.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,
    /// Add depth, position, normal, base colour and emission layers to an EXR.
    #[arg(long)]
    pub layers: bool,
    /// Count light lists against the f64 oracle.
    #[arg(long)]
    pub counters: bool,
    /// Run under validation, synchronization validation and our own checker; any message fails the run.
    #[arg(long)]
    pub validate: bool,
    /// Write the machine form here, - for standard output.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Arguments of `plan`.
#[derive(Debug, Clone, Args)]
pub struct PlanArgs {
    /// A .gltf or .glb file, or builtin:NAME[:key=value,...].
    #[arg(default_value = "builtin:atrium")]
    pub scene: String,
    /// Scene, light and camera.
    #[command(flatten)]
    pub shared: Shared,
    /// Print every barrier of the frame with its reason.
    #[arg(long)]
    pub barriers: bool,
    /// Print the frame's graph in DOT.
    #[arg(long, conflicts_with = "barriers")]
    pub dot: bool,
    /// Write the machine form here, - for standard output.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Arguments of `devices`.
#[derive(Debug, Clone, Args)]
pub struct Devices {
    /// Write the machine form here, - for standard output.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Arguments of `scene`.
#[derive(Debug, Clone, Args)]
pub struct SceneArgs {
    /// NAME[:key=value,...]; without it the names are listed.
    #[arg(requires = "output")]
    pub name: Option<String>,
    /// Where the glTF goes.
    #[arg(short, long, value_name = "FILE.glb")]
    pub output: Option<PathBuf>,
    /// Scatter N coloured point lights, in place of the scene's own.
    #[arg(long, value_name = "N")]
    pub lights: Option<u32>,
    /// Seed of the scattered lights.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub light_seed: u64,
}

/// Arguments of `diff`.
#[derive(Debug, Clone, Args)]
pub struct Diff {
    /// Reference picture, PNG or EXR.
    pub a: PathBuf,
    /// Picture to judge.
    pub b: PathBuf,
    /// Write a heat map of the difference.
    #[arg(short, long, value_name = "FILE.png")]
    pub output: Option<PathBuf>,
    /// Fail where the largest difference of a channel passes X.
    #[arg(long, value_name = "X")]
    pub max: Option<f64>,
    /// Write the machine form here, - for standard output.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Arguments of `check`.
#[derive(Debug, Clone, Args)]
pub struct Check {
    /// Device or driver whose name contains this.
    #[arg(long, value_name = "SUBSTRING")]
    pub driver: Option<String>,
    /// Run under validation and synchronization validation.
    #[arg(long)]
    pub validate: bool,
    /// Run the long ones too: up to an hour.
    #[arg(long)]
    pub deep: bool,
    /// Run only the checks whose name contains this, such as tile_lists.
    #[arg(long, value_name = "SUBSTRING")]
    pub only: Option<String>,
    /// Write the machine form here, - for standard output.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// `--limits`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LimitsChoice {
    /// What the device says.
    Device,
    /// What the specification grants everywhere; needs no driver for `plan`.
    Minimum,
}

/// `--technique`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TechniqueChoice {
    /// The plan chooses.
    Auto,
    /// Every fragment loops over all lights: the definition of the picture.
    Forward,
    /// Lights are added over a G-buffer, as --deferred-lights says.
    Deferred,
    /// Every pixel of a G-buffer loops over the lights of its screen tile.
    TiledDeferred,
    /// Every fragment loops over the lights of its screen tile.
    TiledForward,
    /// Every pixel of a G-buffer loops over the lights of its cluster, a slice of its screen tile.
    ClusteredDeferred,
    /// Every fragment loops over the lights of its cluster.
    ClusteredForward,
    /// Rays in f64 on the CPU: the judge.
    Reference,
}

/// On or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OnOff {
    /// On.
    On,
    /// Off.
    Off,
}

/// `--light-fetch`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FetchArg {
    /// The plan chooses.
    Auto,
    /// Storage buffer.
    Storage,
    /// Uniform buffer.
    Uniform,
    /// Uniform texel buffer.
    Texel,
}

/// `--shading`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ShadingArg {
    /// Diffuse only.
    Lambert,
    /// Ambient, diffuse and Blinn's specular lobe.
    Phong,
    /// glTF's metallic-roughness.
    Gltf,
}

/// `--tonemap`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TonemapArg {
    /// Clip at 1.
    None,
    /// A filmic curve.
    Aces,
    /// Khronos PBR Neutral.
    Neutral,
}

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let (w, h) = text.split_once(['x', 'X']).ok_or("a size is written WxH, e.g. 1280x720")?;
    let number = |t: &str| t.parse::<u32>().map_err(|_| format!("{t:?} is not a number of pixels"));
    match (number(w)?, number(h)?) {
        (0, _) | (_, 0) => Err("a picture needs at least one pixel".into()),
        size => Ok(size),
    }
}

fn parse_angle(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(degrees),
        _ => Err(format!("{text:?} is not an angle between 0 and 180 degrees")),
    }
}

fn parse_triple(text: &str) -> Result<[f64; 3], String> {
    let parts: Vec<_> = text.split(',').collect();
    let [a, b, c] = parts.as_slice() else { return Err("three numbers with commas between are expected".into()) };
    let number = |t: &str| match t.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(format!("{t:?} is not a finite number")),
    };
    Ok([number(a)?, number(b)?, number(c)?])
}
