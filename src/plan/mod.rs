//! What will run, decided before any Vulkan object exists: a pure function of scene, request and limits.

pub mod assign;
pub mod bounced;
mod bytes;
pub mod clusters;
pub mod cost;
mod debug_view;
mod effects;
pub mod gbuffer;
pub mod geometry;
mod light_markers;
mod light_parts;
pub mod light_tree;
pub mod light_volumes;
pub mod lights;
mod limits;
pub mod list_sort;
pub mod materials;
pub mod overrides;
pub mod profile;
pub mod projection;
mod request;
pub mod samples;
pub mod shadows;
pub mod tiles;
pub mod transparency;

use crate::error::{Error, Result};
use crate::scene::lighting::Lighting;
use crate::scene::shading::Shading;
use crate::scene::view::View;
use crate::scene::{LightKind, Scene};
use crate::shared::{self, LightMarker};
use std::collections::BTreeSet;

pub use bounced::Bounced;
pub use clusters::Clusters;
pub use debug_view::DebugView;
pub use effects::{Effect, STATEMENTS, Statement, estimate};
pub use gbuffer::{Deferred, Gbuffer, LightPass};
pub use geometry::Geometry;
pub use light_parts::LightParts;
pub use light_volumes::LightVolumes;
pub use lights::{Fetch, LightTable};
pub use limits::Limits;
pub use overrides::EffectName;
pub use request::{
    Accumulation, AssignChoice, CameraChoice, ClusterBounds, CullTest, DeferredLights, DepthBounds, FetchChoice,
    Gathering, GbufferLayout, Gi, Iteration, MatrixPath, Request, ShadowUpdate, Technique, TransparentBounds,
    TransparentSort,
};
pub use shadows::Shadows;
pub use tiles::Tiles;
pub use transparency::{Transparency, TransparentLists};

/// Bytes of one RGBA32F texel.
const RADIANCE_BYTES: u64 = 16;
/// Bytes of one D32F texel.
const DEPTH_BYTES: u64 = 4;

/// Everything a frame consists of, with the numbers that decided it.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Never `Auto`.
    pub technique: Technique,
    /// Why this technique.
    pub technique_why: String,
    /// BRDF of every lit surface.
    pub shading: Shading,
    /// Camera and picture size.
    pub view: View,
    /// A depth pass runs before shading.
    pub prepass: bool,
    /// Samples a pixel.
    pub samples: u32,
    /// Lights in device form.
    pub lights: LightTable,
    /// Light lists of screen tiles, where the technique has them.
    pub tiles: Option<Tiles>,
    /// Their slices, where the technique has clusters; lists of tiles are made then only where candidates come from them.
    pub clusters: Option<Clusters>,
    /// G-buffer and how lights are added over it, where the technique is a deferred one.
    pub deferred: Option<Deferred>,
    /// Passes that a forward technique adds its lights in.
    pub light_parts: LightParts,
    /// Lights whose way to surfaces is looked at; `None` where there are none.
    pub shadows: Option<Shadows>,
    /// How blended surfaces are lit and mixed; `None` where there are none.
    pub transparency: Option<Transparency>,
    /// When shadow maps are drawn and bounced light is gathered.
    pub shadow_update: ShadowUpdate,
    /// There is room for lights that move ([`Plan::relit`]).
    pub lights_move: bool,
    /// Bounced light, as it was asked for.
    pub gi: Gi,
    /// Bounced light that is gathered; `None` where none is.
    pub bounced: Option<Bounced>,
    /// How it is gathered, or why none is.
    pub bounced_why: String,
    /// Spheres that show where lights are; empty where they are not wanted.
    pub markers: Vec<LightMarker>,
    /// Draws, and where meshes lie in the shared buffers.
    pub geometry: Geometry,
    /// Textures and material constants.
    pub materials: materials::Materials,
    /// Every effect there is, running or not, and why.
    pub effects: Vec<Effect>,
    /// What is shown instead of radiance.
    pub debug_view: Option<DebugView>,
    /// Sentences for the user: what was chosen for them.
    pub notes: Vec<String>,
    /// Lights as shading sees them, f64.
    pub lighting: Lighting,
}

impl Plan {
    /// Plans a picture of `scene` as `request` asks for on a device with `limits`.
    ///
    /// # Errors
    /// A request that cannot be met, in one sentence; nothing has been allocated then.
    pub fn new(scene: &Scene, request: &Request, limits: &Limits) -> Result<Self> {
        match request.technique {
            Technique::Auto => Self::cheapest(scene, request, limits),
            _ => Self::of_technique(scene, request, limits, ("asked for".into(), None)),
        }
    }

    /// The same picture with other lights in `scene`, as the request has them move ([`Request::lights_move`]): surfaces, materials and what was baked
    /// are taken over, all that hangs on lights is planned anew.
    ///
    /// # Errors
    /// As [`Plan::new`]; a request under which lights do not move, or for another picture.
    pub fn relit(self, scene: &Scene, request: &Request, limits: &Limits) -> Result<Self> {
        if !request.lights_move {
            return Err(Error::usage("lights of this picture do not move"));
        }
        let request = Request { technique: self.technique, ..request.clone() };
        let why = self.technique_why.clone();
        Self::of_technique(scene, &request, limits, (why, Some(self)))
    }

    /// The cheapest technique that the limits allow, by the model of `plan/cost.rs`.
    fn cheapest(scene: &Scene, request: &Request, limits: &Limits) -> Result<Self> {
        check_size(request, limits)?;
        let camera = request.camera(scene, &mut Vec::new())?;
        let view = View::new(&camera, request.width, request.height)?;
        let lighting = Lighting::new(scene, &request.light_rules())?;
        let load = cost::Load::new(scene, &lighting, &view, request.tile);
        let profile = limits.profile.clone().unwrap_or_default();
        let ranked = cost::ranked(&profile, &load, request, limits);
        let mut refused = None;
        // First those that have as many samples a pixel as are asked for.
        let has = |technique: Technique| samples::granted(technique, limits) & request.msaa != 0;
        let (having, lacking): (Vec<_>, Vec<_>) = ranked.iter().partition(|(technique, _)| has(*technique));
        for &&(technique, _) in having.iter().chain(&lacking) {
            let why = cost::why(&profile, &ranked, technique);
            let asked = Request { technique, ..request.clone() };
            match Self::of_technique(scene, &asked, limits, (why, None)) {
                Ok(plan) => return Ok(plan),
                Err(error) => refused = refused.or(Some(error)),
            }
        }
        Err(refused.unwrap_or_else(|| Error::new("no technique fits this device")))
    }

    /// `kept` is a plan of the same picture, under other lights.
    fn of_technique(
        scene: &Scene,
        request: &Request,
        limits: &Limits,
        (technique_why, kept): (String, Option<Self>),
    ) -> Result<Self> {
        check_size(request, limits)?;
        let (name, traced) = (request.technique.name(), request.technique == Technique::Reference);
        if matches!(request.gi, Gi::Path { .. }) && !traced {
            return Err(Error::usage(format!(
                "--gi path is traced on the CPU, by --technique reference and not by {name}"
            )));
        }
        if matches!(request.gi, Gi::Radiosity(_)) && traced {
            return Err(Error::usage("--gi radiosity is gathered on a device; --technique reference has --gi path"));
        }
        let mut notes = Vec::new();
        let camera = request.camera(scene, &mut notes)?;
        let view = View::new(&camera, request.width, request.height)?;
        let mut lighting = Lighting::new(scene, &request.light_rules())?;
        note_lighting(&lighting, &mut notes);
        let extent = extent(scene, &view);
        let shadowed = shadows::select(&mut lighting, scene, request, &view, extent);
        let technique = request.technique;
        let samples = samples::decide(request, limits, &mut notes)?;
        if kept.as_ref().is_some_and(|kept| kept.view != view || kept.shading != request.shading) {
            return Err(Error::usage(
                "another camera, size or shading is another picture, which has to be planned anew",
            ));
        }
        let (materials, geometry, gathered) = match kept {
            Some(mut kept) => {
                if let Some(bounced) = &mut kept.bounced {
                    bounced.go_on(&kept.lighting, &lighting)?;
                }
                (kept.materials, kept.geometry, Some((kept.bounced, kept.bounced_why)))
            }
            None => {
                let materials = materials::Materials::new(scene, request.shading, limits)?;
                let geometry = Geometry::new(scene, &view, &materials, request.transparent_sort, limits)?;
                (materials, geometry, None)
            }
        };
        let inputs = shadows::Inputs { scene, view: &view, geometry: &geometry, request, limits, extent };
        let shadows = Shadows::new(&inputs, &mut lighting, &shadowed, &mut notes)?;
        // Samples that one invocation may shade.
        let each = if technique.is_deferred() { samples.max(4) } else { 1 };
        let limits = &shadows.as_ref().map_or(Ok(limits.clone()), |shadows| shadows.leave(each, limits))?;
        let (mut bounced, bounced_why) =
            gathered.map_or_else(|| Bounced::new(request, &view, &lighting, limits), Ok)?;
        let lights = LightTable::new(&lighting, &view, request.fetch_or_default(), limits)?;
        if let Some(bounced) = bounced.as_mut().filter(|_| lights.fetch == Fetch::Storage) {
            bounced.with_lights_in_storage(limits)?;
        }
        let prepass = technique != Technique::Reference && request.prepass && !geometry.draws.is_empty();
        // Views of lists show that they are empty.
        let listed = lighting.lights.iter().any(|l| l.kind != LightKind::Directional) || request.debug_view.is_some();
        let clustered = technique.clusters() && listed;
        let tiled = clustered || (listed && matches!(technique, Technique::TiledForward | Technique::TiledDeferred));
        clusters::check_normals(technique, request)?;
        let request = &clusters::asked(technique, Request { prepass, msaa: samples, ..request.clone() })?;
        let mut tiles = tiled.then(|| Tiles::new(request, &lighting, &view, extent, limits)).transpose()?;
        let cut = tiles.as_ref().filter(|_| clustered);
        let clusters = cut.map(|tiles| Clusters::new(request, tiles, &view, extent, limits)).transpose()?;
        if let Some(tiles) = tiles.as_mut().filter(|_| clusters.as_ref().is_some_and(|c| c.tree.is_some())) {
            // No tile asks for the depths of its samples.
            tiles.bounds = DepthBounds::Off;
        }
        if request.show_lights && technique == Technique::Reference {
            notes.push("--show-lights: the reference draws no markers".into());
        }
        let markers = if request.show_lights { light_markers::markers(&lighting, &view) } else { Vec::new() };
        let mut plan = Self {
            technique,
            technique_why,
            shading: request.shading,
            view,
            prepass,
            samples,
            lights,
            tiles,
            clusters,
            deferred: None,
            light_parts: LightParts::WHOLE,
            shadows,
            transparency: None,
            shadow_update: request.shadow_update,
            lights_move: request.lights_move,
            gi: request.gi,
            bounced,
            bounced_why,
            markers,
            geometry,
            materials,
            effects: Vec::new(),
            debug_view: request.debug_view,
            notes,
            lighting,
        };
        tiles::check_reduction(&plan, request)?;
        plan.deferred = Deferred::new(&mut plan, request, extent, limits)?;
        plan.light_parts = LightParts::new(&mut plan, limits)?;
        samples::check(&plan, request, limits)?;
        plan.transparency = Transparency::new(&mut plan, request, extent, limits)?;
        plan.debug_view.map_or(Ok(()), |view| view.check(&plan))?;
        plan.effects = effects::decide(&plan, scene, request, &shadowed);
        overrides::say(&mut plan.effects, request, &mut plan.notes);
        Ok(plan)
    }

    /// Value of SHADING for passes that light a G-buffer: the one model of all lit opaque surfaces, or that each has its own.
    pub fn deferred_shading(&self) -> u32 {
        let lit = self.geometry.draws.iter().filter(|draw| !draw.variant.unlit).map(|draw| draw.variant.model);
        let models: BTreeSet<u32> = lit.collect();
        match (models.len(), models.first()) {
            (0, _) | (_, None) => materials::shading_constant(self.shading.into()),
            (1, Some(&model)) => model,
            _ => shared::SHADING_MIXED,
        }
    }

    /// Lit opaque surfaces differ in model, or have one with numbers of its own: a G-buffer has to say which material is seen.
    pub fn stores_material(&self) -> bool {
        let one = [shared::SHADING_LAMBERT, shared::SHADING_PHONG, shared::SHADING_GLTF];
        !one.contains(&self.deferred_shading())
    }

    /// Surfaces are stored instead of lit: a debug view of them is wanted.
    pub fn shows_surfaces(&self) -> bool {
        self.debug_view.is_some_and(DebugView::of_surfaces)
    }

    /// Candidates of clusters come from the light hierarchy: no lists of tiles are made.
    pub fn walks_tree(&self) -> bool {
        self.clusters.as_ref().is_some_and(|clusters| clusters.tree.is_some())
    }

    /// The technique makes light lists.
    pub fn has_lists(&self) -> bool {
        self.tiles.is_some()
    }

    /// A deferred technique leaves the samples of each pixel, because something is drawn over them.
    pub fn spreads_samples(&self) -> bool {
        self.samples > 1 && self.deferred.is_some() && self.draws_over()
    }

    /// Something is drawn over the picture of a deferred technique.
    pub fn draws_over(&self) -> bool {
        let unlit = self.geometry.draws.iter().any(|draw| draw.variant.unlit);
        unlit || !self.geometry.blended.is_empty() || !self.markers.is_empty()
    }
}

/// Metres from the eye beyond which nothing is drawn.
fn extent(scene: &Scene, view: &View) -> f64 {
    let bounds = scene.bounds();
    if bounds.is_empty() {
        return 0.0;
    }
    let center = view.world_to_view.transform_point3(bounds.center());
    center.length() + (bounds.max - bounds.min).length() * 0.5
}

fn check_size(request: &Request, limits: &Limits) -> Result<()> {
    let (w, h) = (request.width, request.height);
    if w == 0 || h == 0 {
        return Err(Error::usage(format!("--size {w}x{h} has no pixel")));
    }
    let most = limits.max_image_dimension;
    if w > most || h > most {
        return Err(Error::new(format!("--size {w}x{h} passes this device's largest image, {most}x{most}")));
    }
    // Each layer is read back through a buffer of its own.
    let bytes = u64::from(w) * u64::from(h) * RADIANCE_BYTES;
    if bytes > limits.max_buffer_bytes {
        return Err(Error::new(format!(
            "--size {w}x{h} needs a read-back buffer of {bytes} bytes, this device's largest has {}",
            limits.max_buffer_bytes
        )));
    }
    Ok(())
}

fn note_lighting(lighting: &Lighting, notes: &mut Vec<String>) {
    if lighting.default_light {
        notes.push("the scene has no light: one default directional light of 3 lux is used".into());
    }
    if lighting.absent > 0 {
        notes.push(format!("{} lights never rise above the cut-off and are absent", lighting.absent));
    }
    if lighting.unbounded > 0 {
        notes.push(format!("{} lights have no finite range and reach everything", lighting.unbounded));
    }
}
