//! glTF 2.0 files, as `.gltf` with its companions or as `.glb`, whatever is in them.
//!
//! `serde_json` parses the text, and the parts here walk its tree: the typed document of the `gltf` crate cuts indices
//! to 32 bits and names no field in its errors. From that crate come the numbers that glTF has from OpenGL. No input
//! makes the loader panic, and its memory is bounded by its input (`budget.rs`, `images.rs`).
//!
//! A file either becomes a valid [`Scene`] or one sentence that names file, field and index. What is dropped, replaced
//! or not supported stands in [`Scene::warnings`], once a kind with its count.

use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;

use self::accessor::Accessors;
use self::budget::Budget;
use self::buffers::Buffers;
use self::document::Document;
use self::images::Pictures;
use self::json::Json;
use self::material::MaterialKey;
use self::notes::Notes;
use super::{Sampler, Scene};
use crate::error::{Error, Result};

mod accessor;
mod budget;
mod buffers;
mod decode;
mod document;
mod glb;
mod images;
mod json;
mod json_error;
mod material;
mod mesh;
mod nodes;
mod normals;
mod notes;
mod placed;
mod tangents;
mod topology;
mod unsupported;
mod uri;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_hostile;

/// A file on its way to a scene; the parts of the format add their methods in their own files.
struct Loader<'a> {
    document: &'a Document<'a>,
    buffers: &'a Buffers<'a>,
    /// Folder of the file; `None` where no other file may be read.
    base: Option<&'a Path>,
    accessors: Accessors<'a>,
    pictures: Pictures,
    /// Image and sampler of each texture met.
    textures: HashMap<usize, (Option<usize>, Sampler)>,
    materials: HashMap<MaterialKey, usize>,
    meshes: HashMap<usize, Range<usize>>,
    budget: Budget,
    notes: Notes,
    scene: Scene,
}

/// Reads a `.gltf` or `.glb` file; which of them it is shows in its first bytes.
///
/// # Errors
/// A file that cannot be read or drawn, in one sentence.
pub fn load(path: &Path) -> Result<Scene> {
    let name = path.display().to_string();
    let bytes = uri::read(path)?;
    let base = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    load_slice(&bytes, Some(base), &name)
}

/// Reads a file's bytes; others that it refers to are found from the folder `base`, and refused where that is `None`.
///
/// # Errors
/// A file that cannot be read or drawn, in one sentence that begins with `name`.
pub fn load_slice(bytes: &[u8], base: Option<&Path>, name: &str) -> Result<Scene> {
    read(bytes, base, name).map_err(|e| e.within(name))
}

fn read(bytes: &[u8], base: Option<&Path>, name: &str) -> Result<Scene> {
    if bytes.is_empty() {
        return Err(Error::new("the file is empty"));
    }
    let (text, chunk) = glb::split(bytes)?;
    let mut budget = Budget::new(bytes.len());
    budget.charge_tree(json::tree_bytes(text), text.len())?;
    let json = Json::parse(text)?;
    let document = Document::new(&json)?;
    let mut notes = Notes::default();
    unsupported::check(&document, &mut notes)?;
    let buffers = Buffers::load(&document, chunk, base, &mut budget)?;
    let mut loader = Loader {
        document: &document,
        buffers: &buffers,
        base,
        accessors: Accessors::new(&document, &buffers),
        pictures: Pictures::default(),
        textures: HashMap::new(),
        materials: HashMap::new(),
        meshes: HashMap::new(),
        budget,
        notes,
        scene: Scene { name: name.into(), ..Scene::default() },
    };
    loader.place_nodes()?;
    let Loader { mut scene, notes, .. } = loader;
    scene.warnings = notes.into_sentences();
    scene.validate()?;
    Ok(scene)
}
