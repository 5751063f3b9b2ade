//! What every scene must satisfy before anything else looks at it: indices in range, numbers finite, lists of one
//! length.

use glam::{DMat4, DVec3};

use super::{AlphaMode, Camera, Image, Instance, Light, LightKind, Material, Mesh, Projection, Scene, Texture};
use crate::error::{Error, Result};

/// How far from 1 the length of a unit vector may be: eight times what rounding to f32 does.
const UNIT_TOLERANCE: f64 = 1e-6;

/// Normals and tangents come from interpolating tools; their length only scales a dot product.
const NORMAL_TOLERANCE: f64 = 1e-3;

/// Checks everything; the first thing that is wrong is named.
pub(super) fn scene(scene: &Scene) -> Result<()> {
    for (i, image) in scene.images.iter().enumerate() {
        check_image(image).map_err(|e| named(e, "image", i, &image.name))?;
    }
    for (i, material) in scene.materials.iter().enumerate() {
        check_material(material, scene.images.len()).map_err(|e| named(e, "material", i, &material.name))?;
    }
    for (i, mesh) in scene.meshes.iter().enumerate() {
        check_mesh(mesh, &scene.materials).map_err(|e| named(e, "mesh", i, &mesh.name))?;
    }
    for (i, instance) in scene.instances.iter().enumerate() {
        check_instance(instance, scene.meshes.len()).map_err(|e| named(e, "instance", i, ""))?;
    }
    for (i, light) in scene.lights.iter().enumerate() {
        check_light(light).map_err(|e| named(e, "light", i, &light.name))?;
    }
    for (i, camera) in scene.cameras.iter().enumerate() {
        check_camera(camera).map_err(|e| named(e, "camera", i, &camera.name))?;
    }
    Ok(())
}

fn named(e: Error, kind: &str, index: usize, name: &str) -> Error {
    if name.is_empty() {
        e.within(format_args!("{kind} {index}"))
    } else {
        e.within(format_args!("{kind} {index} \"{name}\""))
    }
}

fn wrong<T>(message: String) -> Result<T> {
    Err(Error::new(message))
}

fn check_image(image: &Image) -> Result<()> {
    let bytes = u64::from(image.width) * u64::from(image.height) * 4;
    if bytes == 0 || bytes != image.rgba8.len() as u64 {
        return wrong(format!("{}x{} texels do not fit {} bytes", image.width, image.height, image.rgba8.len()));
    }
    Ok(())
}

/// Each number finite and from `least` to `most`.
fn check_numbers(name: &str, numbers: &[f32], least: f32, most: f32) -> Result<()> {
    match numbers.iter().position(|x| !(x.is_finite() && *x >= least && *x <= most)) {
        Some(at) => wrong(format!("{name}[{at}] is {}, not a number from {least} to {most}", numbers[at])),
        None => Ok(()),
    }
}

/// Largest exponent of a material's model: beyond it a rim is narrower than a pixel ever shows.
const MOST_EXPONENT: f32 = 1024.0;

fn check_material(material: &Material, image_count: usize) -> Result<()> {
    check_numbers("base_color", &material.base_color, 0.0, f32::MAX)?;
    check_numbers("emissive", &material.emissive, 0.0, f32::MAX)?;
    check_numbers("metallic", &[material.metallic], 0.0, 1.0)?;
    check_numbers("roughness", &[material.roughness], 0.0, 1.0)?;
    check_numbers("occlusion_strength", &[material.occlusion_strength], 0.0, 1.0)?;
    check_numbers("normal_scale", &[material.normal_scale], f32::MIN, f32::MAX)?;
    if let Some(own) = &material.model {
        check_numbers("model color", &own.color, 0.0, f32::MAX)?;
        check_numbers("model exponent", &[own.exponent], f32::MIN_POSITIVE, MOST_EXPONENT)?;
    }
    if let Some(height) = &material.height {
        check_numbers("height scale", &[height.scale], 0.0, 1.0)?;
        if height.channel > 3 {
            return wrong(format!("height channel is {}, there are 4", height.channel));
        }
    }
    if let AlphaMode::Mask(cutoff) = material.alpha {
        check_numbers("alpha cut-off", &[cutoff], 0.0, f32::MAX)?;
    }
    for (name, texture) in textures(material) {
        if texture.image >= image_count {
            return wrong(format!("{name} uses image {}, there are {image_count}", texture.image));
        }
        if texture.uv_set > 1 {
            return wrong(format!("{name} uses coordinate set {}, there are 2", texture.uv_set));
        }
        check_numbers(&format!("{name}.uv_transform"), texture.uv_transform.as_flattened(), f32::MIN, f32::MAX)?;
    }
    Ok(())
}

/// The material's textures with their names.
pub(super) fn textures(material: &Material) -> impl Iterator<Item = (&'static str, &Texture)> {
    [
        ("base_color_texture", &material.base_color_texture),
        ("metallic_roughness_texture", &material.metallic_roughness_texture),
        ("normal_texture", &material.normal_texture),
        ("occlusion_texture", &material.occlusion_texture),
        ("emissive_texture", &material.emissive_texture),
    ]
    .into_iter()
    .filter_map(|(name, texture)| texture.as_ref().map(|texture| (name, texture)))
    .chain(material.height.as_ref().map(|height| ("height_texture", &height.texture)))
}

fn check_mesh(mesh: &Mesh, materials: &[Material]) -> Result<()> {
    let count = mesh.positions.len();
    for (name, length, is_optional) in [
        ("normals", mesh.normals.len(), false),
        ("tangents", mesh.tangents.len(), true),
        ("uvs[0]", mesh.uvs[0].len(), true),
        ("uvs[1]", mesh.uvs[1].len(), true),
        ("colors", mesh.colors.len(), true),
    ] {
        if length != count && !(is_optional && length == 0) {
            return wrong(format!("{name} has {length} elements for {count} positions"));
        }
    }
    check_elements("positions", &mesh.positions)?;
    check_elements("tangents", &mesh.tangents)?;
    check_elements("uvs[0]", &mesh.uvs[0])?;
    check_elements("uvs[1]", &mesh.uvs[1])?;
    check_elements("colors", &mesh.colors)?;
    check_unit("normals", mesh.normals.iter().copied())?;
    check_unit("tangents", mesh.tangents.iter().map(|t| [t[0], t[1], t[2]]))?;
    if let Some(at) = mesh.tangents.iter().position(|t| t[3].abs() != 1.0) {
        return wrong(format!("tangents[{at}] has the sign {}", mesh.tangents[at][3]));
    }
    if !mesh.indices.len().is_multiple_of(3) {
        return wrong(format!("{} indices are not whole triangles", mesh.indices.len()));
    }
    if let Some(at) = mesh.indices.iter().position(|index| *index as usize >= count) {
        return wrong(format!("indices[{at}] is {}, there are {count} vertices", mesh.indices[at]));
    }
    let Some(material) = materials.get(mesh.material) else {
        return wrong(format!("material {} of {}", mesh.material, materials.len()));
    };
    for (name, texture) in textures(material) {
        if mesh.uvs[texture.uv_set].is_empty() && count > 0 {
            return wrong(format!("{name} reads uvs[{}], which the mesh has not", texture.uv_set));
        }
    }
    if mesh.tangents.is_empty() && count > 0 {
        let named = [(material.normal_texture.is_some(), "a normal map"), (material.height.is_some(), "a height map")];
        if let Some((_, what)) = named.iter().find(|named| named.0) {
            return wrong(format!("the material has {what}, but the mesh has no tangents"));
        }
    }
    Ok(())
}

fn check_elements<const N: usize>(name: &str, elements: &[[f32; N]]) -> Result<()> {
    match elements.iter().position(|element| element.iter().any(|x| !x.is_finite())) {
        Some(at) => wrong(format!("{name}[{at}] is {:?}, not finite", elements[at])),
        None => Ok(()),
    }
}

fn check_unit(name: &str, vectors: impl Iterator<Item = [f32; 3]>) -> Result<()> {
    for (at, vector) in vectors.enumerate() {
        let length = DVec3::from_array(vector.map(f64::from)).length();
        let is_unit = (length - 1.0).abs() <= NORMAL_TOLERANCE;
        if !is_unit {
            return wrong(format!("{name}[{at}] is {vector:?}, not of unit length"));
        }
    }
    Ok(())
}

fn check_matrix(matrix: &DMat4) -> Result<()> {
    if !matrix.is_finite() {
        return wrong("the matrix is not finite".into());
    }
    if matrix.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
        return wrong("the matrix is not affine".into());
    }
    let determinant = matrix.determinant();
    if determinant == 0.0 || !matrix.inverse().is_finite() {
        return wrong(format!("the matrix has no inverse (determinant {determinant})"));
    }
    Ok(())
}

fn check_instance(instance: &Instance, mesh_count: usize) -> Result<()> {
    if instance.mesh >= mesh_count {
        return wrong(format!("mesh {} of {mesh_count}", instance.mesh));
    }
    check_matrix(&instance.object_to_world)
}

fn check_light(light: &Light) -> Result<()> {
    check_numbers("color", &light.color, 0.0, f32::MAX)?;
    check_numbers("intensity", &[light.intensity], 0.0, f32::MAX)?;
    if !light.position.is_finite() {
        return wrong(format!("the position {} is not finite", light.position));
    }
    if light.kind != LightKind::Point {
        let length = light.direction.length();
        if length == 0.0 {
            return wrong("the light has a zero axis".into());
        }
        let is_unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
        if !is_unit {
            return wrong(format!("the axis has length {length} instead of 1"));
        }
    } else if !light.direction.is_finite() {
        return wrong("the axis is not finite".into());
    }
    if let Some(range) = light.range
        && !(range.is_finite() && range > 0.0)
    {
        return wrong(format!("the range {range} is not a positive distance"));
    }
    if let LightKind::Spot { inner, outer } = light.kind
        && !(0.0 <= inner && inner <= outer && outer <= std::f32::consts::PI)
    {
        return wrong(format!("the cone from {inner} to {outer} rad is not within 0 <= inner <= outer <= pi"));
    }
    Ok(())
}

fn check_camera(camera: &Camera) -> Result<()> {
    check_matrix(&camera.camera_to_world)?;
    let axes = glam::DMat3::from_mat4(camera.camera_to_world);
    if !(axes.transpose() * axes).abs_diff_eq(glam::DMat3::IDENTITY, UNIT_TOLERANCE) || axes.determinant() < 0.0 {
        return wrong("the matrix is not a rotation and a translation".into());
    }
    let numbers = match camera.projection {
        Projection::Perspective { yfov, aspect, znear, zfar } => {
            let (aspect, zfar) = (aspect.unwrap_or(1.0), zfar.unwrap_or(f64::MAX));
            [("yfov", yfov), ("aspect", aspect), ("znear", znear), ("zfar", zfar)]
        }
        Projection::Orthographic { xmag, ymag, znear, zfar } => {
            [("xmag", xmag), ("ymag", ymag), ("znear", znear), ("zfar", zfar)]
        }
    };
    match numbers.iter().find(|(_, x)| !x.is_finite()) {
        Some((field, x)) => wrong(format!("{field} is {x}, not a finite number")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{IDENTITY_UV, Sampler};

    fn good() -> Scene {
        let texture = Texture { image: 0, sampler: Sampler::default(), uv_set: 1, uv_transform: IDENTITY_UV };
        let mesh = Mesh {
            name: "m".into(),
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            uvs: [vec![], vec![[0.0; 2]; 3]],
            indices: vec![0, 1, 2],
            ..Mesh::default()
        };
        Scene {
            meshes: vec![mesh],
            materials: vec![Material { base_color_texture: Some(texture), ..Material::default() }],
            images: vec![Image { name: String::new(), width: 2, height: 1, rgba8: vec![0; 8] }],
            instances: vec![Instance { mesh: 0, object_to_world: DMat4::IDENTITY }],
            lights: vec![Light {
                name: "lamp".into(),
                kind: LightKind::Spot { inner: 0.5, outer: 0.5 },
                color: [1.0; 3],
                intensity: 1.0,
                position: DVec3::ZERO,
                direction: DVec3::NEG_Y,
                range: Some(1.0),
                shadow: false,
            }],
            cameras: vec![Camera::looking(DVec3::ONE, DVec3::ZERO, 1.0)],
            ..Scene::default()
        }
    }

    type Spoil = fn(&mut Scene);

    #[test]
    fn each_kind_of_wrong_is_named() {
        good().validate().unwrap();
        let cases: [(Spoil, &str); 22] = [
            (|s| s.images[0].rgba8.truncate(7), "image 0: 2x1"),
            (|s| s.materials[0].base_color[2] = f32::NAN, "material 0: base_color[2] is NaN"),
            (|s| s.materials[0].roughness = -0.5, "roughness[0] is -0.5"),
            (|s| s.materials[0].emissive[0] = f32::INFINITY, "emissive[0]"),
            (|s| s.images.clear(), "base_color_texture uses image 0"),
            (|s| s.meshes[0].normals.truncate(2), "mesh 0 \"m\": normals has 2 elements for 3"),
            (|s| s.meshes[0].positions[1][2] = f32::INFINITY, "positions[1]"),
            (|s| s.meshes[0].normals[2] = [0.0; 3], "normals[2]"),
            (|s| s.meshes[0].normals[2][0] = f32::NAN, "normals[2]"),
            (|s| s.meshes[0].indices[1] = 3, "indices[1] is 3"),
            (|s| s.meshes[0].indices.truncate(2), "whole triangles"),
            (|s| s.meshes[0].material = 1, "material 1 of 1"),
            (|s| s.meshes[0].uvs[1].clear(), "reads uvs[1]"),
            (|s| s.instances[0].mesh = 5, "instance 0: mesh 5 of 1"),
            (|s| s.instances[0].object_to_world.y_axis = glam::DVec4::ZERO, "no inverse"),
            (|s| s.instances[0].object_to_world.y_axis.w = 1.0, "not affine"),
            (|s| s.lights[0].direction = DVec3::ZERO, "light 0 \"lamp\": the light has a zero axis"),
            (|s| s.lights[0].direction = DVec3::X * 1e20, "length"),
            (|s| s.lights[0].range = Some(0.0), "range 0"),
            (|s| s.lights[0].kind = LightKind::Spot { inner: 0.6, outer: 0.5 }, "cone"),
            (|s| s.lights[0].intensity = -1.0, "intensity"),
            (|s| s.cameras[0].camera_to_world.x_axis *= 2.0, "camera 0 \"look-at\": the matrix is not a rotation"),
        ];
        for (spoil, words) in cases {
            let mut scene = good();
            spoil(&mut scene);
            let said = scene.validate().map_or_else(|e| e.to_string(), |()| "accepted".into());
            assert!(said.contains(words), "{words}: {said}");
        }
    }
}
