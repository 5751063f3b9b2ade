//! The node hierarchy: world transforms in f64, and what stands at each node.

use glam::{DMat4, DQuat, DVec3};

use super::Loader;
use super::json::Value;
use super::notes::Note;
use crate::error::{Error, Result};
use crate::scene::{Camera, Instance, Light};

/// Deepest hierarchy; real ones have some dozens of levels.
const MAX_DEPTH: usize = 10_000;

/// Most meshes placed in one scene.
const MAX_INSTANCES: usize = 1 << 20;

/// A node whose children are being visited.
struct Frame<'a> {
    world: DMat4,
    children: Box<dyn Iterator<Item = Value<'a>> + 'a>,
}

/// What a scene will hold, so that lists of the right length can be asked for.
#[derive(Default)]
struct Counts {
    instances: usize,
    lights: usize,
    cameras: usize,
}

impl<'a> Loader<'a> {
    /// Fills the scene's instances, lights and cameras, and reads the meshes they need.
    ///
    /// # Errors
    /// Nodes that are no tree, transforms that are not affine, and all errors of meshes, lights and cameras.
    pub(super) fn place_nodes(&mut self) -> Result<()> {
        let roots = self.roots()?;
        let mut counts = Counts::default();
        self.walk(&roots, &mut |loader, node, world| loader.count_node(node, world, &mut counts))?;
        let bytes = counts.instances * size_of::<Instance>()
            + counts.lights * (size_of::<Light>() + 64)
            + counts.cameras * (size_of::<Camera>() + 64);
        self.budget.charge(bytes as u64, 0, &"nodes")?;
        self.scene.instances.reserve_exact(counts.instances);
        self.scene.lights.reserve_exact(counts.lights);
        self.scene.cameras.reserve_exact(counts.cameras);
        self.walk(&roots, &mut |loader, node, world| loader.place_node(node, world))
    }

    /// The default scene's roots, else the first scene's, else all nodes that are no one's child.
    fn roots(&self) -> Result<Vec<u32>> {
        let scene = match self.document.root.get("scene")? {
            Some(scene) => Some(self.document.scenes.referred(scene)?.1),
            None => self.document.scenes.at(0),
        };
        let nodes = &self.document.nodes;
        if let Some(scene) = scene {
            let Some(list) = scene.get("nodes")? else {
                return Ok(Vec::new());
            };
            let mut roots = Vec::with_capacity(list.elements()?.count());
            for node in list.elements()? {
                roots.push(nodes.referred(node)?.0 as u32);
            }
            return Ok(roots);
        }
        let mut is_child = vec![false; nodes.len()];
        for node in nodes.iter() {
            if let Some(children) = node.get("children")? {
                for child in children.elements()? {
                    is_child[nodes.referred(child)?.0] = true;
                }
            }
        }
        let count = is_child.iter().filter(|is_child| !**is_child).count();
        let mut roots = Vec::with_capacity(count);
        roots.extend((0..).zip(&is_child).filter(|(_, is_child)| !**is_child).map(|(node, _)| node));
        Ok(roots)
    }

    /// Visits all nodes below `roots`, parents first, each with its transform to world space.
    fn walk(&mut self, roots: &[u32], visit: &mut dyn FnMut(&mut Self, Value<'a>, DMat4) -> Result<()>) -> Result<()> {
        let mut reached = vec![false; self.document.nodes.len()];
        let mut stack: Vec<Frame<'a>> = Vec::new();
        for root in roots {
            let mut next = Some((*root as usize, DMat4::IDENTITY));
            loop {
                if let Some((index, parent)) = next.take() {
                    let Some(node) = self.document.nodes.at(index) else {
                        break;
                    };
                    if std::mem::replace(&mut reached[index], true) {
                        return Err(node.error("is reached twice, but nodes must form a tree"));
                    }
                    if stack.len() == MAX_DEPTH {
                        return Err(node.error(format_args!("is nested deeper than {MAX_DEPTH} nodes")));
                    }
                    let world = parent * local_transform(node)?;
                    if !world.is_finite() {
                        return Err(node.error("the transform to world space is not finite"));
                    }
                    visit(self, node, world)?;
                    if let Some(children) = node.get("children")? {
                        stack.push(Frame { world, children: Box::new(children.elements()?) });
                    }
                }
                let Some(frame) = stack.last_mut() else {
                    break;
                };
                match frame.children.next() {
                    Some(child) => next = Some((self.document.nodes.referred(child)?.0, frame.world)),
                    None => drop(stack.pop()),
                }
            }
        }
        Ok(())
    }

    fn count_node(&mut self, node: Value<'a>, world: DMat4, counts: &mut Counts) -> Result<()> {
        if let Some(mesh) = node.get("mesh")?
            && is_invertible(&world)
        {
            counts.instances += self.mesh(mesh)?.len();
            if counts.instances > MAX_INSTANCES {
                return Err(Error::new(format!("nodes: the scene places more than {MAX_INSTANCES} primitives")));
            }
        }
        counts.lights += usize::from(node.extension("KHR_lights_punctual")?.is_some());
        counts.cameras += usize::from(node.get("camera")?.is_some());
        Ok(())
    }

    fn place_node(&mut self, node: Value<'a>, world: DMat4) -> Result<()> {
        if let Some(mesh) = node.get("mesh")? {
            self.notes.add_many(Note::Skins, node.get("skin")?.is_some().into());
            self.notes.add_many(Note::GpuInstancing, node.extension("EXT_mesh_gpu_instancing")?.is_some().into());
            if is_invertible(&world) {
                let placed = self.mesh(mesh)?.map(|mesh| Instance { mesh, object_to_world: world });
                self.scene.instances.extend(placed);
            } else {
                self.notes.add(Note::FlatNode);
            }
        }
        if let Some(light) = node.extension("KHR_lights_punctual")? {
            self.place_light(node, light, world)?;
        }
        if let Some(camera) = node.get("camera")? {
            self.place_camera(node, camera, world)?;
        }
        Ok(())
    }
}

pub(super) fn is_invertible(world: &DMat4) -> bool {
    let determinant = world.determinant();
    determinant != 0.0 && determinant.is_finite() && world.inverse().is_finite()
}

/// `matrix`, else translation times rotation times scale (glTF 2.0, section 3.5.3).
fn local_transform(node: Value<'_>) -> Result<DMat4> {
    if let Some(matrix) = node.get("matrix")? {
        let mut m = matrix.numbers::<16>()?;
        let last_row = [m[3], m[7], m[11], m[15] - 1.0];
        if last_row.iter().any(|x| x.abs() > 1e-6) {
            return Err(matrix.error("the last row is not 0 0 0 1"));
        }
        (m[3], m[7], m[11], m[15]) = (0.0, 0.0, 0.0, 1.0);
        return Ok(DMat4::from_cols_array(&m));
    }
    let vector = |key: &str, default: f64| -> Result<DVec3> {
        Ok(DVec3::from_array(node.get(key)?.map_or(Ok([default; 3]), Value::numbers::<3>)?))
    };
    let rotation = match node.get("rotation")? {
        Some(rotation) => {
            let q = DQuat::from_array(rotation.numbers::<4>()?);
            if q.length_squared() == 0.0 {
                return Err(rotation.error("the quaternion has length 0"));
            }
            q.normalize()
        }
        None => DQuat::IDENTITY,
    };
    Ok(DMat4::from_scale_rotation_translation(vector("scale", 1.0)?, rotation, vector("translation", 0.0)?))
}
