//! Nodes of a glTF file: instances, lights and cameras. All are roots, in this order.

use std::f64::consts::FRAC_PI_2;

use glam::{DMat4, DVec3};
use serde::Serialize;
use serde_json::{Value, json};

use super::{named, power_of_two_over, wide};
use crate::error::{Error, Result};
use crate::scene::{Camera, Light, LightKind, Projection, Scene};

/// The extension that lights belong to.
pub const LIGHTS: &str = "KHR_lights_punctual";

/// Largest cosine between the axes of a node that glTF's translation, rotation and scale can describe: rounding of matrices
/// that came from f32.
const SHEAR_TOLERANCE: f64 = 1e-5;

/// Nodes and what they refer to. Typed, because a scene may have a million lights.
pub struct Nodes<'a> {
    /// Instances, then lights, then cameras.
    pub nodes: Vec<Node<'a>>,
    /// In light-id order.
    pub lights: Vec<LightObject<'a>>,
    /// In the scene's order.
    pub cameras: Vec<Value>,
}

/// A root of the scene; absent properties are left out.
#[derive(Serialize, Default)]
pub struct Node<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    camera: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    matrix: Option<[f64; 16]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    translation: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    extensions: Option<NodeExtensions>,
}

#[derive(Serialize)]
struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    lights: LightReference,
}

#[derive(Serialize)]
struct LightReference {
    light: usize,
}

/// An element of `KHR_lights_punctual.lights`.
#[derive(Serialize)]
pub struct LightObject<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    #[serde(rename = "type")]
    kind: &'static str,
    color: [f64; 3],
    intensity: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    range: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    spot: Option<Spot>,
    #[serde(skip_serializing_if = "Option::is_none")]
    extras: Option<LightExtras>,
}

/// What glTF has no word for.
#[derive(Serialize)]
struct LightExtras {
    lampyris: OwnLight,
}

#[derive(Serialize)]
struct OwnLight {
    shadow: bool,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Spot {
    inner_cone_angle: f64,
    outer_cone_angle: f64,
}

/// The lights of the whole file.
#[derive(Serialize)]
pub struct RootExtensions<'a> {
    #[serde(rename = "KHR_lights_punctual")]
    lights: LightList<'a>,
}

#[derive(Serialize)]
struct LightList<'a> {
    lights: &'a [LightObject<'a>],
}

impl<'a> RootExtensions<'a> {
    /// None without lights.
    pub fn new(lights: &'a [LightObject<'a>]) -> Option<Self> {
        (!lights.is_empty()).then_some(Self { lights: LightList { lights } })
    }
}

impl<'a> Nodes<'a> {
    /// Nodes for every instance, light and camera of the scene.
    pub fn new(scene: &'a Scene) -> Result<Self> {
        let count = scene.instances.len() + scene.lights.len() + scene.cameras.len();
        let mut all = Self { nodes: Vec::with_capacity(count), lights: Vec::new(), cameras: Vec::new() };
        for (index, instance) in scene.instances.iter().enumerate() {
            let matrix = matrix(&instance.object_to_world).map_err(|e| e.within(format!("instance {index}")))?;
            let name = scene.meshes.get(instance.mesh).and_then(|mesh| not_empty(&mesh.name));
            all.nodes.push(Node { name, mesh: Some(instance.mesh), matrix, ..Node::default() });
        }
        for (index, light) in scene.lights.iter().enumerate() {
            let object = light_object(light).map_err(|e| e.within(format!("light {index} \"{}\"", light.name)))?;
            all.lights.push(object);
            let (matrix, translation) = light_place(light);
            let extensions = Some(NodeExtensions { lights: LightReference { light: index } });
            let name = not_empty(&light.name);
            all.nodes.push(Node { name, matrix, translation, extensions, ..Node::default() });
        }
        for (index, camera) in scene.cameras.iter().enumerate() {
            let context = || format!("camera {index} \"{}\"", camera.name);
            all.cameras.push(camera_object(camera).map_err(|e| e.within(context()))?);
            let matrix = matrix(&camera.camera_to_world).map_err(|e| e.within(context()))?;
            all.nodes.push(Node { name: not_empty(&camera.name), camera: Some(index), matrix, ..Node::default() });
        }
        Ok(all)
    }
}

fn not_empty(name: &str) -> Option<&str> {
    (!name.is_empty()).then_some(name)
}

/// Column-major; none for the identity. glTF allows only what translation, rotation and scale can make (section 3.5.3).
fn matrix(to_world: &DMat4) -> Result<Option<[f64; 16]>> {
    if *to_world == DMat4::IDENTITY {
        return Ok(None);
    }
    let axes = [to_world.x_axis, to_world.y_axis, to_world.z_axis].map(|axis| axis.truncate());
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        if axes[i].dot(axes[j]).abs() > SHEAR_TOLERANCE * axes[i].length() * axes[j].length() {
            return Err(Error::new("its transform is sheared, which a glTF node cannot be"));
        }
    }
    Ok(Some(to_world.to_cols_array()))
}

/// Matrix or translation of a light's node. The third axis is the exact opposite of the direction, which a quaternion
/// would round.
fn light_place(light: &Light) -> (Option<[f64; 16]>, Option<[f64; 3]>) {
    if light.kind == LightKind::Point || light.direction == DVec3::NEG_Z {
        return (None, (light.position != DVec3::ZERO).then(|| light.position.to_array()));
    }
    let back = -light.direction;
    let (right, up) = back.any_orthonormal_pair();
    let place = DMat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), light.position.extend(1.0));
    (Some(place.to_cols_array()), None)
}

fn light_object(light: &Light) -> Result<LightObject<'_>> {
    // Colour components end at 1; what is beyond goes to the intensity.
    let split = power_of_two_over(light.color.into_iter().fold(0.0, f32::max));
    let (kind, spot) = match light.kind {
        LightKind::Directional => ("directional", None),
        LightKind::Point => ("point", None),
        LightKind::Spot { inner, outer } => ("spot", Some(cone(inner, outer)?)),
    };
    let range = light.range.filter(|_| light.kind != LightKind::Directional);
    if range.is_some_and(|range| range <= 0.0) {
        return Err(Error::new("its range is 0; glTF's begin above that"));
    }
    Ok(LightObject {
        name: not_empty(&light.name),
        kind,
        color: wide(light.color).map(|component| component / split),
        intensity: f64::from(light.intensity) * split,
        range: range.map(f64::from),
        spot,
        extras: light.shadow.then_some(LightExtras { lampyris: OwnLight { shadow: true } }),
    })
}

/// glTF demands 0 <= inner < outer <= pi / 2.
fn cone(inner: f32, outer: f32) -> Result<Spot> {
    // The f32 nearest to pi / 2 lies above it; it reads back from the f64 below.
    let outer_cone_angle = if outer == FRAC_PI_2 as f32 { FRAC_PI_2 } else { f64::from(outer) };
    if !(outer_cone_angle > 0.0 && outer_cone_angle <= FRAC_PI_2) {
        return Err(Error::new(format!("its outer cone angle is {outer} rad; glTF's are from 0 to pi / 2")));
    }
    // One step of f32 is far below the 0.001 that the falloff of the cone rounds its width up to.
    let inner_cone_angle = f64::from(inner.min(outer.next_down()).max(0.0));
    Ok(Spot { inner_cone_angle, outer_cone_angle })
}

fn camera_object(camera: &Camera) -> Result<Value> {
    let object = match camera.projection {
        Projection::Perspective { yfov, aspect, znear, zfar } => {
            let mut lens = json!({ "yfov": yfov, "znear": znear });
            if let Some(aspect) = aspect.filter(|aspect| aspect.is_finite() && *aspect > 0.0) {
                lens["aspectRatio"] = json!(aspect);
            }
            if let Some(zfar) = zfar {
                lens["zfar"] = json!(zfar);
            }
            json!({ "type": "perspective", "perspective": lens })
        }
        Projection::Orthographic { xmag, ymag, znear, zfar } => {
            if znear < 0.0 {
                return Err(Error::new(format!("its znear is {znear}; glTF's begin at 0")));
            }
            let lens = json!({ "xmag": xmag, "ymag": ymag, "znear": znear, "zfar": zfar });
            json!({ "type": "orthographic", "orthographic": lens })
        }
    };
    Ok(named(&camera.name, object))
}
