//! A camera made ready for one picture: the world-to-view transform in f64 and the extents of the image plane.

use glam::{DMat4, DVec2, DVec3};

use super::{Camera, Light, LightKind, Projection, Scene};
use crate::error::{Error, Result};

/// View space: right-handed, +X right, +Y up, the camera at the origin looking along -Z, metres.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Name of the camera it came from, for reports.
    pub name: String,
    /// Rigid.
    pub world_to_view: DMat4,
    /// How view space meets the image plane.
    pub lens: Lens,
    /// Nothing nearer is drawn: distance along -Z, metres.
    pub znear: f64,
    /// Nothing farther is drawn, where given.
    pub zfar: Option<f64>,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
}

/// Extents of the image: at distance 1 for a perspective lens, anywhere for an orthographic one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lens {
    /// Rays leave the origin; `left` to `right` and `bottom` to `top` are tangents.
    Perspective(Extents),
    /// Rays run along -Z; extents in metres.
    Orthographic(Extents),
}

/// A rectangle on the image plane, `left < right` and `bottom < top` unless the camera mirrors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extents {
    /// At the left edge of pixel column 0.
    pub left: f64,
    /// At the right edge of the last column.
    pub right: f64,
    /// At the lower edge of the last row.
    pub bottom: f64,
    /// At the upper edge of row 0.
    pub top: f64,
}

impl Lens {
    /// The extents of either kind.
    pub fn extents(&self) -> Extents {
        match *self {
            Self::Perspective(extents) | Self::Orthographic(extents) => extents,
        }
    }

    /// True where the picture is a mirror image.
    pub fn mirrors(&self) -> bool {
        let e = self.extents();
        (e.left > e.right) != (e.bottom > e.top)
    }

    /// True for a perspective lens.
    pub fn is_perspective(&self) -> bool {
        matches!(self, Self::Perspective(_))
    }
}

impl View {
    /// Makes `camera` ready for a picture of `width` x `height` pixels.
    ///
    /// # Errors
    /// A lens that no picture can come through: an angle outside (0, pi), an empty extent, a near plane that is not in
    /// front of the far plane.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Result<Self> {
        let refuse = |what: String| Err(Error::new(format!("camera \"{}\": {what}", camera.name)));
        if width == 0 || height == 0 {
            return refuse(format!("a picture of {width}x{height} pixels has no pixel"));
        }
        let (lens, znear, zfar) = match camera.projection {
            Projection::Perspective { yfov, aspect, znear, zfar } => {
                if !(yfov > 0.0 && yfov < std::f64::consts::PI) {
                    return refuse(format!("the vertical field of view is {yfov} rad, not between 0 and pi"));
                }
                let top = (yfov * 0.5).tan();
                let picture = width as f64 / height as f64;
                let aspect = aspect.filter(|a| a.is_finite() && *a > 0.0).unwrap_or(picture);
                // A file's own aspect never stretches: what it shows stays visible, the picture shows more on one side.
                let (right, top) =
                    if picture >= aspect { (top * picture, top) } else { (top * aspect, top * aspect / picture) };
                if !(znear > 0.0 && znear.is_finite()) {
                    return refuse(format!("znear is {znear}, not a positive distance"));
                }
                (Lens::Perspective(Extents { left: -right, right, bottom: -top, top }), znear, zfar)
            }
            Projection::Orthographic { xmag, ymag, znear, zfar } => {
                if !(xmag != 0.0 && ymag != 0.0 && xmag.is_finite() && ymag.is_finite()) {
                    return refuse(format!("xmag {xmag} and ymag {ymag} must not be 0"));
                }
                let picture = width as f64 / height as f64;
                let own = (xmag / ymag).abs();
                let (right, top) =
                    if picture >= own { (xmag * picture / own, ymag) } else { (xmag, ymag * own / picture) };
                (Lens::Orthographic(Extents { left: -right, right, bottom: -top, top }), znear, Some(zfar))
            }
        };
        if !znear.is_finite() {
            return refuse(format!("znear is {znear}, not a finite distance"));
        }
        if zfar.is_some_and(|far| !far.is_finite() || far <= znear) {
            return refuse(format!("zfar {} is not a distance beyond znear {znear}", zfar.unwrap_or(f64::NAN)));
        }
        let view = Self {
            name: camera.name.clone(),
            world_to_view: camera.camera_to_world.inverse(),
            lens,
            znear,
            zfar,
            width,
            height,
        };
        // The device computes in f32: an angle of 1e-40 or a near plane of 1e-50 m has no place in it.
        let clip = view.view_to_clip().as_mat4().to_cols_array();
        let near_vanishes = view.lens.is_perspective() && (znear as f32) < f32::MIN_POSITIVE;
        if clip.iter().any(|x| !x.is_finite()) || near_vanishes {
            let lens = match camera.projection {
                Projection::Perspective { yfov, .. } => format!("a field of view of {yfov} rad and a znear of {znear}"),
                Projection::Orthographic { xmag, ymag, .. } => format!("xmag {xmag} and ymag {ymag}"),
            };
            return refuse(format!("{lens} pass what 32-bit floats can draw"));
        }
        Ok(view)
    }

    /// A view whose space is the world: for what asks for rays and not for pictures.
    pub fn of_world() -> Self {
        Self {
            name: "world".into(),
            world_to_view: DMat4::IDENTITY,
            lens: Lens::Perspective(Extents { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 }),
            znear: 1e-3,
            zfar: None,
            width: 1,
            height: 1,
        }
    }

    /// The point of the image plane under the centre of pixel (`x`, `y`), row 0 at the top; see [`Lens`] for units.
    pub fn image_point(&self, x: f64, y: f64) -> DVec2 {
        let e = self.lens.extents();
        let (u, v) = ((x + 0.5) / self.width as f64, (y + 0.5) / self.height as f64);
        DVec2::new(e.left + (e.right - e.left) * u, e.top + (e.bottom - e.top) * v)
    }

    /// The view whose pixels have in their middle what is so many pixels to the right and down in this one.
    pub fn moved(&self, right: f64, down: f64) -> Self {
        let shift = |e: Extents| {
            let across = right * (e.right - e.left) / f64::from(self.width);
            let along = down * (e.bottom - e.top) / f64::from(self.height);
            Extents { left: e.left + across, right: e.right + across, bottom: e.bottom + along, top: e.top + along }
        };
        let lens = match self.lens {
            Lens::Perspective(extents) => Lens::Perspective(shift(extents)),
            Lens::Orthographic(extents) => Lens::Orthographic(shift(extents)),
        };
        Self { lens, ..self.clone() }
    }

    /// Origin and (unnormalised, z = -1) direction of the ray through a pixel's centre, in view space.
    pub fn ray(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let p = self.image_point(x, y);
        match self.lens {
            Lens::Perspective(_) => (DVec3::ZERO, DVec3::new(p.x, p.y, -1.0)),
            Lens::Orthographic(_) => (DVec3::new(p.x, p.y, 0.0), DVec3::new(0.0, 0.0, -1.0)),
        }
    }

    /// View to clip, column-major. Depth is reversed: 1 at `znear`, 0 at `zfar` or, for a perspective lens without one, at
    /// infinity. Clip-space y points down, as Vulkan has it.
    pub fn view_to_clip(&self) -> DMat4 {
        let e = self.lens.extents();
        let (w, h) = (e.right - e.left, e.top - e.bottom);
        let (cx, cy) = ((e.right + e.left) / w, (e.top + e.bottom) / h);
        match self.lens {
            Lens::Perspective(_) => {
                // Without a far plane: depth = znear / distance. With one: 0 at zfar, so that the rasteriser clips there.
                let (scale, offset) = match self.zfar.filter(|far| far.is_finite()) {
                    Some(far) => (self.znear / (far - self.znear), self.znear * far / (far - self.znear)),
                    None => (0.0, self.znear),
                };
                DMat4::from_cols_array(&[
                    2.0 / w,
                    0.0,
                    0.0,
                    0.0, //
                    0.0,
                    -2.0 / h,
                    0.0,
                    0.0, //
                    cx,
                    -cy,
                    scale,
                    -1.0, //
                    0.0,
                    0.0,
                    offset,
                    0.0,
                ])
            }
            Lens::Orthographic(_) => {
                let far = self.zfar.unwrap_or(self.znear + 1.0);
                let depth = far - self.znear;
                DMat4::from_cols_array(&[
                    2.0 / w,
                    0.0,
                    0.0,
                    0.0, //
                    0.0,
                    -2.0 / h,
                    0.0,
                    0.0, //
                    0.0,
                    0.0,
                    1.0 / depth,
                    0.0, //
                    -cx,
                    cy,
                    far / depth,
                    1.0,
                ])
            }
        }
    }
}

impl Camera {
    /// A camera at `from` that looks at `at`, +Y up (or -Z up when it looks straight up or down).
    pub fn looking(from: DVec3, at: DVec3, yfov: f64) -> Self {
        let forward = (at - from).try_normalize().unwrap_or(DVec3::NEG_Z);
        let up = if forward.y.abs() > 0.9999 { DVec3::NEG_Z } else { DVec3::Y };
        let right = forward.cross(up).normalize();
        let up = right.cross(forward);
        let camera_to_world =
            DMat4::from_cols(right.extend(0.0), up.extend(0.0), (-forward).extend(0.0), from.extend(1.0));
        Self {
            name: "look-at".into(),
            camera_to_world,
            projection: Projection::Perspective { yfov, aspect: None, znear: 0.05, zfar: None },
        }
    }

    /// A camera from which the whole of the scene is seen: a little from the right and above, from the front (+Z) or, where its lights
    /// stand behind it, from the back.
    pub fn framing(scene: &Scene, aspect: f64) -> Self {
        let bounds = &scene.bounds();
        let yfov = 45f64.to_radians();
        let (center, radius) = if bounds.is_empty() {
            (DVec3::ZERO, 1.0)
        } else {
            (bounds.center(), ((bounds.max - bounds.min).length() * 0.5).max(1e-6))
        };
        let half = (yfov * 0.5).tan() * aspect.min(1.0);
        let distance = radius / half.atan().sin();
        let behind = |light: &Light| match light.kind {
            LightKind::Directional => -light.direction.z,
            _ => ((light.position - center).z / radius).clamp(-1.0, 1.0),
        };
        let side = if scene.lights.iter().map(behind).sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
        let direction = DVec3::new(0.35 * side, 0.3, side).normalize();
        let mut camera = Self::looking(center + direction * distance, center, yfov);
        camera.name = "framing".into();
        let znear = ((distance - radius) * 0.1).max(radius * 1e-3);
        camera.projection = Projection::Perspective { yfov, aspect: None, znear, zfar: None };
        camera
    }
}
