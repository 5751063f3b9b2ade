//! Lights (KHR_lights_punctual) and cameras (glTF 2.0, section 3.10) at a node.

use std::f32::consts::{FRAC_PI_4, PI};

use glam::{DMat3, DMat4, DVec3};

use super::Loader;
use super::json::Value;
use super::material::{at_least_zero, non_negative};
use super::nodes::is_invertible;
use super::notes::Note;
use crate::error::Result;
use crate::scene::{Camera, Light, LightKind, Projection};

impl<'a> Loader<'a> {
    /// Adds the light that a node's extension names. The node's scale changes neither range nor intensity.
    ///
    /// # Errors
    /// A number outside its range, with the light's name.
    pub(super) fn place_light(&mut self, node: Value<'a>, extension: Value<'a>, world: DMat4) -> Result<()> {
        let (index, light) = self.document.lights.referred(extension.require("light")?)?;
        let node_name = node.name_or(|| format!("lights[{index}]"))?;
        let name = light.name_or(|| node_name)?;
        let known = ["shadow"];
        let unknown = light.own_extras()?.map_or(0, |own| own.unknown_members(&known));
        let light = read_light(light, name.clone(), world).map_err(|e| e.within(format_args!("light \"{name}\"")))?;
        self.notes.add_many(Note::UnknownExtras, unknown);
        self.scene.lights.push(light);
        Ok(())
    }

    /// Adds the camera that a node names.
    ///
    /// # Errors
    /// A lens that no picture can come through.
    pub(super) fn place_camera(&mut self, node: Value<'a>, camera: Value<'a>, world: DMat4) -> Result<()> {
        let (index, camera) = self.document.cameras.referred(camera)?;
        let projection = read_projection(camera)?;
        if !is_invertible(&world) {
            self.notes.add(Note::FlatCamera);
            return Ok(());
        }
        let camera_name = camera.name_or(|| format!("cameras[{index}]"))?;
        let name = node.name_or(|| camera_name)?;
        self.notes.add_many(Note::MirroredCamera, (world.determinant() < 0.0).into());
        self.scene.cameras.push(Camera { name, camera_to_world: rigid(&world), projection });
        Ok(())
    }
}

fn read_light(light: Value<'_>, name: String, world: DMat4) -> Result<Light> {
    let kind_name = light.require("type")?;
    let kind = match kind_name.text()? {
        "directional" => LightKind::Directional,
        "point" => LightKind::Point,
        "spot" => read_cone(light)?,
        _ => return Err(kind_name.error("is not directional, point or spot")),
    };
    let range = match light.get("range")? {
        Some(range) if range.float()? <= 0.0 => {
            return Err(range.error(format_args!("{} is not a positive distance", range.float()?)));
        }
        Some(range) => Some(range.float()?),
        None => None,
    };
    let direction = match world.transform_vector3(DVec3::NEG_Z).try_normalize() {
        Some(direction) => direction,
        None if kind == LightKind::Point => DVec3::NEG_Z,
        None => return Err(light.error("a node scales the light's axis to zero length")),
    };
    Ok(Light {
        name,
        kind,
        color: light.get("color")?.map_or(Ok([1.0; 3]), non_negative::<3>)?,
        intensity: light.get("intensity")?.map_or(Ok(1.0), at_least_zero)?,
        position: world.w_axis.truncate(),
        direction,
        range,
        shadow: read_shadow(light)?,
    })
}

/// `extras.lampyris.shadow`; `extras` of other programs may be anything.
fn read_shadow(light: Value<'_>) -> Result<bool> {
    match light.own_extras()? {
        Some(own) => own.get("shadow")?.map_or(Ok(false), Value::boolean),
        None => Ok(false),
    }
}

fn read_cone(light: Value<'_>) -> Result<LightKind> {
    let Some(spot) = light.get("spot")? else {
        return Ok(LightKind::Spot { inner: 0.0, outer: FRAC_PI_4 });
    };
    let inner = spot.get("innerConeAngle")?.map_or(Ok(0.0), at_least_zero)?;
    let outer = spot.get("outerConeAngle")?.map_or(Ok(FRAC_PI_4), at_least_zero)?;
    if outer > PI {
        return Err(spot.error(format_args!("outerConeAngle {outer} is greater than pi")));
    }
    if inner > outer {
        return Err(spot.error(format_args!("innerConeAngle {inner} is greater than outerConeAngle {outer}")));
    }
    Ok(LightKind::Spot { inner, outer })
}

fn read_projection(camera: Value<'_>) -> Result<Projection> {
    let kind = camera.require("type")?;
    match kind.text()? {
        "perspective" => {
            let lens = camera.require("perspective")?;
            let yfov = lens.require("yfov")?;
            if !(yfov.number()? > 0.0 && yfov.number()? < std::f64::consts::PI) {
                return Err(yfov.error(format_args!("{} is not between 0 and pi", yfov.number()?)));
            }
            let znear = positive(lens.require("znear")?)?;
            let zfar = lens.get("zfar")?.map(positive).transpose()?;
            if zfar.is_some_and(|zfar| zfar <= znear) {
                return Err(lens.error("zfar is not beyond znear"));
            }
            let aspect = lens.get("aspectRatio")?.map(positive).transpose()?;
            Ok(Projection::Perspective { yfov: yfov.number()?, aspect, znear, zfar })
        }
        "orthographic" => {
            let lens = camera.require("orthographic")?;
            let magnification = |key: &str| -> Result<f64> {
                let value = lens.require(key)?;
                if value.number()? == 0.0 { Err(value.error("must not be 0")) } else { value.number() }
            };
            let (znear, zfar) = (lens.require("znear")?.number()?, lens.require("zfar")?.number()?);
            if zfar <= znear {
                return Err(lens.error("zfar is not beyond znear"));
            }
            let (xmag, ymag) = (magnification("xmag")?, magnification("ymag")?);
            Ok(Projection::Orthographic { xmag, ymag, znear, zfar })
        }
        _ => Err(kind.error("is not perspective or orthographic")),
    }
}

fn positive(value: Value<'_>) -> Result<f64> {
    let number = value.number()?;
    if number > 0.0 { Ok(number) } else { Err(value.error(format_args!("{number} is not positive"))) }
}

/// The rotation and translation of `world`: its view axis and the plane of its view and up axes are kept, x follows
/// from them, so that a mirrored node gives an image that is not mirrored.
fn rigid(world: &DMat4) -> DMat4 {
    let axes = DMat3::from_mat4(*world);
    let back = axes.z_axis.try_normalize().unwrap_or(DVec3::Z);
    let up = (axes.y_axis - back * back.dot(axes.y_axis)).try_normalize();
    let up = up.unwrap_or_else(|| back.any_orthonormal_vector());
    let right = up.cross(back);
    DMat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), world.w_axis)
}
