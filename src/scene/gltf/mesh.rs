//! Meshes: every primitive of triangles becomes one [`Mesh`], complete in every attribute that its material reads.

use std::ops::Range;

use ::gltf::json::mesh as codes;

use super::Loader;
use super::accessor::Reader;
use super::json::Value;
use super::material::MaterialKey;
use super::notes::Note;
use super::topology::{Mode, compact, compact_bytes, drop_zero_area, vertex_bytes};
use super::{normals, tangents};
use crate::error::Result;
use crate::scene::validate::textures;
use crate::scene::{Material, Mesh, Texture};

/// A primitive whose vertices have been chosen.
struct Primitive<'a> {
    value: Value<'a>,
    attributes: Value<'a>,
    /// Elements of every attribute's accessor.
    count: usize,
    /// Which of them are used.
    source: Vec<u32>,
}

impl<'a> Loader<'a> {
    /// The range of [`crate::scene::Scene::meshes`] that the mesh named by the number `reference` became, on first use.
    ///
    /// # Errors
    /// Data that cannot be read, or would need more memory than the file warrants.
    pub(super) fn mesh(&mut self, reference: Value<'a>) -> Result<Range<usize>> {
        let (index, mesh) = self.document.meshes.referred(reference)?;
        if let Some(known) = self.meshes.get(&index) {
            return Ok(known.clone());
        }
        self.budget.charge(4 * size_of::<(usize, Range<usize>)>() as u64, 0, &mesh)?;
        let name = mesh.name_or(|| format!("meshes[{index}]"))?;
        let primitives = mesh.require("primitives")?;
        let single = primitives.elements()?.nth(1).is_none();
        let start = self.scene.meshes.len();
        for (number, primitive) in primitives.elements()?.enumerate() {
            let name = if single { name.clone() } else { format!("{name}[{number}]") };
            if let Some(mesh) = self.primitive(primitive, name)? {
                self.scene.meshes.push(mesh);
            }
        }
        let range = start..self.scene.meshes.len();
        self.meshes.insert(index, range.clone());
        Ok(range)
    }

    fn primitive(&mut self, value: Value<'a>, name: String) -> Result<Option<Mesh>> {
        let attributes = value.require("attributes")?;
        if let Some(targets) = value.get("targets")? {
            self.notes.add_many(Note::MorphTargets, targets.elements()?.next().is_some().into());
        }
        if value.extension("KHR_draco_mesh_compression")?.is_some() {
            self.notes.add(Note::Draco);
        }
        let Some(mode) = self.mode(value)? else {
            return Ok(None);
        };
        let Some(position) = attributes.get("POSITION")? else {
            self.notes.add(Note::WithoutPositions);
            return Ok(None);
        };
        let positions = self.attribute(position, &[3], None)?;
        let mut indices = self.triangle_list(value, mode, positions.count)?;
        let source = compact(&mut indices, positions.count);
        // Three times a mesh and its name, since the list of meshes grows by doubling.
        let bytes = 3 * (size_of::<Mesh>() + name.len()) + 12 * source.len();
        self.budget.charge(bytes as u64, 0, &value)?;
        let mut mesh = Mesh { name, positions: positions.gather(&source), indices, ..Mesh::default() };
        let primitive = Primitive { value, attributes, count: positions.count, source };
        check_finite(&mesh.positions, &primitive.source, position, &positions)?;
        self.notes.add_many(Note::ZeroArea, drop_zero_area(&mut mesh));
        if mesh.indices.is_empty() {
            return Ok(None);
        }
        self.surface(&primitive, &mut mesh)?;
        self.shading_frame(&primitive, &mut mesh)?;
        Ok(Some(mesh))
    }

    /// `None`: points or lines, which are counted.
    fn mode(&mut self, primitive: Value<'a>) -> Result<Option<Mode>> {
        let Some(mode) = primitive.get("mode")? else {
            return Ok(Some(Mode::List));
        };
        match mode.code()? {
            codes::POINTS => self.notes.add(Note::Points),
            codes::LINES | codes::LINE_LOOP | codes::LINE_STRIP => self.notes.add(Note::Lines),
            codes::TRIANGLES => return Ok(Some(Mode::List)),
            codes::TRIANGLE_STRIP => return Ok(Some(Mode::Strip)),
            codes::TRIANGLE_FAN => return Ok(Some(Mode::Fan)),
            other => return Err(mode.error(format_args!("{other} is not a primitive mode"))),
        }
        Ok(None)
    }

    /// Opens an attribute of one of `widths` components and, where given, `count` elements.
    fn attribute(&mut self, value: Value<'a>, widths: &[usize], count: Option<usize>) -> Result<Reader<'a>> {
        let reader = self.accessors.reader(value, &mut self.budget)?;
        let (id, width) = (reader.id, reader.width);
        if !widths.contains(&width) {
            let wanted = widths[0];
            return Err(value.error(format_args!("accessors[{id}] has {width} components instead of {wanted}")));
        }
        match count {
            Some(count) if count != reader.count => {
                Err(value
                    .error(format_args!("accessors[{id}] has {} elements, but POSITION has {count}", reader.count)))
            }
            _ => Ok(reader),
        }
    }

    /// Corners by the accessor's vertex numbers, all below `vertex_count`.
    fn triangle_list(&mut self, primitive: Value<'a>, mode: Mode, vertex_count: usize) -> Result<Vec<u32>> {
        let Some(indices) = primitive.get("indices")? else {
            self.charge_corners(primitive, mode.corner_count(vertex_count), vertex_count)?;
            self.note_incomplete(mode, vertex_count);
            // Fewer than 2^32 vertices: no file is larger than that many bytes, and the charge above has counted them.
            return Ok(mode.triangle_list(vertex_count, |corner| corner as u32));
        };
        let reader = self.accessors.reader(indices, &mut self.budget)?;
        let id = reader.id;
        if reader.width != 1 || !reader.component.is_unsigned() {
            return Err(indices.error(format_args!("accessors[{id}] is not a list of unsigned integers")));
        }
        self.charge_corners(primitive, mode.corner_count(reader.count), vertex_count)?;
        self.note_incomplete(mode, reader.count);
        for at in 0..reader.count {
            let index = reader.index(at);
            if index as usize >= vertex_count {
                return Err(indices.error(format_args!(
                    "accessors[{id}]: index {at} is {index}, but POSITION has {vertex_count} elements"
                )));
            }
        }
        Ok(mode.triangle_list(reader.count, |corner| reader.index(corner)))
    }

    fn charge_corners(&mut self, primitive: Value<'a>, corner_count: usize, vertex_count: usize) -> Result<()> {
        let passing = compact_bytes(corner_count, vertex_count).saturating_add(4 * corner_count as u64);
        self.budget.charge(4 * corner_count as u64, passing, &primitive)
    }

    fn note_incomplete(&mut self, mode: Mode, count: usize) {
        let incomplete = if mode == Mode::List { !count.is_multiple_of(3) } else { count < 3 };
        self.notes.add_many(Note::IncompleteTriangles, incomplete.into());
    }

    /// Material, texture coordinates and colours.
    fn surface(&mut self, primitive: &Primitive<'a>, mesh: &mut Mesh) -> Result<()> {
        let index = match primitive.value.get("material")? {
            Some(material) => Some(self.document.materials.referred(material)?.0),
            None => None,
        };
        let sets = [primitive.attributes.get("TEXCOORD_0")?, primitive.attributes.get("TEXCOORD_1")?];
        mesh.material = self.material(MaterialKey { index, normal_map: true })?;
        if tangent_textures(&self.scene.materials[mesh.material]).any(|texture| sets[texture.uv_set].is_none()) {
            self.notes.add(Note::NormalMapWithoutUvs);
            mesh.material = self.material(MaterialKey { index, normal_map: false })?;
        }
        let mut is_used = [false; 2];
        for (_, texture) in textures(&self.scene.materials[mesh.material]) {
            is_used[texture.uv_set] = true;
        }
        let mut is_absent = false;
        for (set, (value, is_used)) in sets.into_iter().zip(is_used).enumerate() {
            if !is_used {
                continue;
            }
            mesh.uvs[set] = match value {
                Some(value) => self.read_attribute(primitive, value, &[2])?,
                None => {
                    is_absent = true;
                    self.budget.charge(8 * primitive.source.len() as u64, 0, &primitive.value)?;
                    vec![[0.0; 2]; primitive.source.len()]
                }
            };
        }
        self.notes.add_many(Note::TextureWithoutUvs, is_absent.into());
        if let Some(value) = primitive.attributes.get("COLOR_0")? {
            mesh.colors = self.read_attribute(primitive, value, &[4, 3])?;
        }
        Ok(())
    }

    /// The used elements of an attribute, all finite.
    fn read_attribute<const N: usize>(
        &mut self,
        primitive: &Primitive<'a>,
        value: Value<'a>,
        widths: &[usize],
    ) -> Result<Vec<[f32; N]>> {
        let reader = self.attribute(value, widths, Some(primitive.count))?;
        self.budget.charge((4 * N * primitive.source.len()) as u64, 0, &value)?;
        let elements = reader.gather(&primitive.source);
        check_finite(&elements, &primitive.source, value, &reader)?;
        Ok(elements)
    }

    /// Normals, and tangents where the material has a map that needs them.
    fn shading_frame(&mut self, primitive: &Primitive<'a>, mesh: &mut Mesh) -> Result<()> {
        let vertex_count = primitive.source.len();
        let normal = primitive.attributes.get("NORMAL")?;
        if let Some(value) = normal {
            let reader = self.attribute(value, &[3], Some(primitive.count))?;
            self.budget.charge(12 * vertex_count as u64, 24 * vertex_count as u64, &value)?;
            mesh.normals = reader.gather(&primitive.source);
            self.notes.add_many(Note::NormalsReplaced, normals::repair(mesh));
        } else {
            let corner_bytes = (vertex_bytes(mesh) + 12) * mesh.indices.len();
            self.budget.charge(corner_bytes as u64, 4 * mesh.indices.len() as u64, &primitive.value)?;
            normals::make_flat(mesh);
        }
        if tangent_textures(&self.scene.materials[mesh.material]).next().is_none() {
            return Ok(());
        }
        // Without normals a file's tangents mean nothing (glTF 2.0, section 3.7.2.1).
        match primitive.attributes.get("TANGENT")? {
            Some(value) if normal.is_some() => {
                let reader = self.attribute(value, &[4], Some(primitive.count))?;
                self.budget.charge(16 * vertex_count as u64, 0, &value)?;
                mesh.tangents = reader.gather(&primitive.source);
                self.notes.add_many(Note::TangentsReplaced, tangents::repair(mesh));
                Ok(())
            }
            _ => self.make_tangents(primitive, mesh),
        }
    }

    fn make_tangents(&mut self, primitive: &Primitive<'a>, mesh: &mut Mesh) -> Result<()> {
        let Some(texture) = tangent_textures(&self.scene.materials[mesh.material]).next().cloned() else {
            return Ok(());
        };
        let corners = mesh.indices.len();
        let before = mesh.positions.len();
        let bytes = vertex_bytes(mesh);
        // Every corner may become a vertex of its own while they are sorted.
        let passing = corners / 3 * tangents::BYTES_PER_TRIANGLE + corners * (2 * bytes + 48);
        let replaced = if self.budget.has_room(passing as u64) && tangents::suits_mikktspace(mesh) {
            tangents::make_mikktspace(mesh, &texture)
        } else {
            self.notes.add(Note::TangentsSimplified);
            self.budget.charge(0, 64 * before as u64, &primitive.value)?;
            tangents::make_averaged(mesh, &texture)
        };
        self.notes.add_many(Note::TangentsReplaced, replaced);
        let added = mesh.positions.len().saturating_sub(before) * bytes + 16 * mesh.positions.len();
        self.budget.charge(added as u64, 0, &primitive.value)
    }
}

/// Maps whose directions are those of tangents; the first one decides them.
fn tangent_textures(material: &Material) -> impl Iterator<Item = &Texture> {
    material.normal_texture.iter().chain(material.height.iter().map(|height| &height.texture))
}

fn check_finite<const N: usize>(
    elements: &[[f32; N]],
    source: &[u32],
    attribute: Value<'_>,
    reader: &Reader<'_>,
) -> Result<()> {
    let bad = elements.iter().zip(source).find(|(element, _)| element.iter().any(|x| !x.is_finite()));
    match bad {
        Some((_, index)) => {
            Err(attribute.error(format_args!("accessors[{}]: element {index} is not a finite number", reader.id)))
        }
        None => Ok(()),
    }
}
