//! Extensions and features that this loader does not draw, named to the user.

use std::collections::BTreeSet;

use super::document::Document;
use super::json::shorten;
use super::notes::{Note, Notes};
use crate::error::Result;

/// Drawn as their specifications say.
const SUPPORTED: [&str; 5] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Said with a count of their own where they are met.
const COUNTED: [&str; 6] = [
    "EXT_mesh_gpu_instancing",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_texture_basisu",
    "MSFT_texture_dds",
];

/// Most names in one sentence.
const MAX_NAMES: usize = 12;

/// Looks through the lists of extensions and the animations.
///
/// # Errors
/// An extension that is required and not supported.
pub(super) fn check(document: &Document<'_>, notes: &mut Notes) -> Result<()> {
    if let Some(required) = document.root.get("extensionsRequired")? {
        for name in required.elements()? {
            let text = name.text()?;
            if !SUPPORTED.contains(&text) {
                return Err(name.error(format_args!("the file requires {}, which is not supported", shorten(text))));
            }
        }
    }
    let mut names = NameList::default();
    let mut looks = NameList::default();
    if let Some(used) = document.root.get("extensionsUsed")? {
        for name in used.elements()? {
            let text = name.text()?;
            if SUPPORTED.contains(&text) || COUNTED.contains(&text) {
                continue;
            }
            if text.starts_with("KHR_materials_") {
                looks.add(&format!("{} ({})", shorten(text), material_count(document, text)?));
            } else {
                names.add(text);
            }
        }
    }
    if let Some(names) = names.sentence() {
        notes.say(format!("extensions that are not supported and ignored: {names}"));
    }
    if let Some(looks) = looks.sentence() {
        notes.say(format!("materials are drawn without the extensions {looks}"));
    }
    if let Some(animations) = document.root.get("animations")? {
        notes.add_many(Note::Animations, animations.elements()?.count() as u64);
    }
    Ok(())
}

/// Materials that carry an extension.
fn material_count(document: &Document<'_>, extension: &str) -> Result<usize> {
    let mut count = 0;
    if let Some(materials) = document.root.get("materials")? {
        for material in materials.elements()? {
            if let Some(extensions) = material.get("extensions")? {
                count += usize::from(extensions.get(extension)?.is_some());
            }
        }
    }
    Ok(count)
}

/// Names in alphabetical order, each once, at most [`MAX_NAMES`].
#[derive(Default)]
struct NameList {
    names: BTreeSet<String>,
    more: usize,
}

impl NameList {
    fn add(&mut self, name: &str) {
        let name = shorten(name);
        if self.names.contains(name) {
            return;
        }
        if self.names.len() < MAX_NAMES {
            self.names.insert(name.to_owned());
        } else {
            self.more += 1;
        }
    }

    fn sentence(&self) -> Option<String> {
        if self.names.is_empty() {
            return None;
        }
        let list = self.names.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        Some(if self.more > 0 { format!("{list} and {} more", self.more) } else { list })
    }
}

#[cfg(test)]
mod tests {
    use super::super::json::Json;
    use super::*;

    fn warnings(text: &str) -> Result<Vec<String>> {
        let json = Json::parse(text.as_bytes())?;
        let document = Document::new(&json)?;
        let mut notes = Notes::default();
        check(&document, &mut notes)?;
        Ok(notes.into_sentences())
    }

    #[test]
    fn used_extensions_are_named_once() {
        let said = warnings(
            r#"{"asset":{"version":"2.0"},"animations":[{},{}],"extensionsUsed":["KHR_xmp","KHR_materials_sheen",
            "KHR_xmp","KHR_materials_ior","KHR_texture_transform","EXT_texture_webp"],"materials":[{},
            {"extensions":{"KHR_materials_ior":{}}},{"extensions":{"KHR_materials_ior":{}}}]}"#,
        )
        .unwrap();
        assert_eq!(
            said,
            [
                "extensions that are not supported and ignored: KHR_xmp",
                "materials are drawn without the extensions KHR_materials_ior (2), KHR_materials_sheen (0)",
                "2 animations: not played, the scene is drawn at rest",
            ]
        );
    }

    #[test]
    fn required_extensions_are_refused_by_name() {
        let e = warnings(
            r#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_texture_transform","KHR_draco_mesh_compression"]}"#,
        );
        let e = e.unwrap_err().to_string();
        assert_eq!(e, "extensionsRequired[1]: the file requires KHR_draco_mesh_compression, which is not supported");
    }
}
