//! Lampyris lights scenes with very many lights on hand-managed Vulkan; a reference in f64 on the CPU judges its pictures.
//!
//! A picture comes to be one way only, and each step is plain data that can be looked at before the next one runs:
//!
//! | step | is made by | is |
//! |---|---|---|
//! | scene | [`scene::gltf::load`], [`scene::builtin::load`], or by hand and [`scene::Scene::validate`] | meshes, materials, lights, cameras |
//! | plan | [`plan::Plan::new`] | what runs and why, and every size; needs no driver |
//! | graph | [`passes::frame`], [`graph::hazard::derive`] | nodes and resources, and the barriers between them |
//! | renderer | [`renderer::Renderer::prepare`] | Vulkan objects and an uploaded scene, drawn by [`renderer::Prepared::draw`] |
//! | picture | [`renderer::Prepared::read_back`], or [`reference::render::Reference::render`] on the CPU | scene-linear radiance, for [`measure`] |
//!
//! # Without a device
//!
//! A closed room that emits 1 nit and reflects nothing has the radiance 1 in every direction. It is planned for the
//! least that Vulkan grants everywhere, the frame that would be recorded is listed, and the picture is traced on the CPU:
//!
//! ```
//! use lampyris::graph::{describe, hazard};
//! use lampyris::passes;
//! use lampyris::plan::{Limits, Plan, Request};
//! use lampyris::reference::render::Reference;
//! use lampyris::reference::shade::Shader;
//! use lampyris::scene::builtin;
//! use lampyris::scene::shading::Shading;
//!
//! let scene = builtin::load("furnace:albedo=0")?;
//!
//! let request = Request { width: 16, height: 9, shading: Shading::Lambert, ..Request::default() };
//! let plan = Plan::new(&scene, &request, &Limits::MINIMUM)?;
//! for effect in &plan.effects {
//!     println!("{} {}: {}", if effect.runs { "runs" } else { "skipped" }, effect.name, effect.why);
//! }
//!
//! let frame = passes::frame(&plan);
//! let barriers = hazard::derive(&frame.graph);
//! let listing = describe::listing(&frame.graph, &barriers);
//! for line in listing.lines().take(4) {
//!     println!("{line}");
//! }
//! assert!(listing.starts_with("depth_prepass\n"));
//!
//! let reference = Reference::new(&scene, &plan.view)?;
//! let shader = Shader::new(&plan.lighting, &plan.view, plan.shading);
//! let picture = reference.render(&shader, &|_rows_done| ());
//! assert_eq!(picture.rgba.len(), 16 * 9);
//! assert!(picture.rgba.iter().all(|pixel| *pixel == [1.0; 4]));
//! # Ok::<(), lampyris::Error>(())
//! ```
//!
//! # On a device
//!
//! The plan is made for what the device grants. [`renderer::Prepared::draw`] keeps two frames in flight and times each
//! pass; the read-back copies what the last frame left, so at least one has to be drawn before it:
//!
//! ```no_run
//! use lampyris::Error;
//! use lampyris::gpu::Options;
//! use lampyris::plan::{Plan, Request};
//! use lampyris::renderer::Renderer;
//! use lampyris::scene::builtin;
//!
//! let scene = builtin::load("atrium")?;
//! let renderer = Renderer::new(&Options::default())?;
//! let plan = Plan::new(&scene, &Request::default(), &renderer.limits())?;
//!
//! let mut prepared = renderer.prepare(&scene, &plan)?;
//! let times = prepared.draw(3)?;
//! let picture = prepared.read_back()?;
//!
//! for (pass, milliseconds) in times.nodes() {
//!     match milliseconds {
//!         Some(ms) => println!("{pass} {ms:.3} ms"),
//!         None => println!("{pass}, on a device without timestamps"),
//!     }
//! }
//! let radiance = picture.rgba("radiance").ok_or_else(|| Error::new("the frame has no radiance"))?;
//! println!("{} pixels of RGBA in f32, rows from the top", radiance.len());
//! # Ok::<(), lampyris::Error>(())
//! ```
//!
//! `examples/compare.rs` in the repository does both and says how far the two pictures are apart.
//!
//! # Modules
//!
//! - [`scene`]: what is drawn, in glTF's units; [`scene::scatter`] makes lights, [`scene::write`] glTF files. The steps
//!   after it trust the indices of a scene that has been validated, as loaders do and whoever makes one by hand has to.
//! - [`plan`]: the decisions, a pure function of scene, request and limits.
//! - [`graph`] and [`passes`]: the frame as data; [`graph::describe`] prints it, [`graph::checker`] proves from a log
//!   that what was recorded is ordered.
//! - [`renderer`]: the way through on a device; below it [`gpu`] owns Vulkan's objects, [`record`] writes commands and
//!   [`submit`] runs them.
//! - [The reference](mod@reference): the same picture by rays in f64.
//! - [`lists`]: light lists as a device makes them, judged in f64 and counted; [`gbuffer`]: what it stores of surfaces.
//! - [`measure`]: [`measure::metrics`] compares pictures, [`measure::times`] has medians, [`measure::exposure`] and
//!   [`measure::file`] lead to a PNG or an EXR.
//! - [`checks`]: the hard cases that `lampyris check` prints, to be run on any device.
//! - [`commands`] and [`cli`]: the program. [`shared`] and [`shaders`]: what Rust and GLSL both know.
//! - [`error`]: one type, whose text is a sentence for a person.
//!
//! # What is stable
//!
//! Before version 1.0, as Cargo counts versions, a change of the second number may change any signature, and
//! `CHANGELOG.md` says so. The functions of the table above and the types that they take and return are meant to stay.
//! [`cli`], [`commands`], [`shared`] and [`shaders`] are public for the program and its tests and change at any time.
//! Types of `ash` ([`graph`], [`gpu`], [`record`], [`submit`]) and of `glam` ([`scene`]) are part of the interface, at
//! the versions that `Cargo.toml` names. In the program's machine forms keys are only ever added.
#![warn(missing_docs)]

pub mod checks;
pub mod cli;
pub mod commands;
pub mod error;
pub mod gbuffer;
pub mod gpu;
pub mod graph;
pub mod lists;
pub mod math;
pub mod measure;
pub mod passes;
pub mod plan;
pub mod profile_file;
pub mod radiosity;
pub mod record;
pub mod reference;
pub mod renderer;
pub mod scene;
pub mod shared;
pub mod submit;
pub mod whole_file;

/// Programs under `glsl/`, generated by `build.rs`.
#[allow(missing_docs, clippy::all)]
pub mod shaders {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}

pub use error::{Error, Result};
