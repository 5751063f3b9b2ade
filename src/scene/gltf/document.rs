//! The arrays of a glTF document, any element of which is one step away.

use super::json::{Json, Value};
use crate::error::Result;

/// One of the arrays that other parts of the document refer into.
pub(super) struct Array<'a> {
    name: &'static str,
    /// `None` where the file has no such array.
    list: Option<Value<'a>>,
    len: usize,
}

impl<'a> Array<'a> {
    fn new(holder: Option<Value<'a>>, name: &'static str) -> Result<Self> {
        let list = match holder {
            Some(holder) => holder.get(name)?,
            None => None,
        };
        let len = match list {
            Some(list) => list.elements()?.len(),
            None => 0,
        };
        Ok(Self { name, list, len })
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Element `index`, where there is one.
    pub(super) fn at(&self, index: usize) -> Option<Value<'a>> {
        self.list?.element(index)
    }

    /// Every element.
    pub(super) fn iter(&self) -> impl Iterator<Item = Value<'a>> + '_ {
        (0..self.len).filter_map(|index| self.at(index))
    }

    /// The element that the number `reference` names, and that number.
    ///
    /// # Errors
    /// A number that is none or too large, with the place it stands in.
    pub(super) fn referred(&self, reference: Value<'a>) -> Result<(usize, Value<'a>)> {
        let index = reference.index()?;
        match self.at(index) {
            Some(element) => Ok((index, element)),
            None => {
                Err(reference.error(format_args!("{index} is out of range, the file has {} {}", self.len, self.name)))
            }
        }
    }
}

/// The arrays that the loader uses.
pub(super) struct Document<'a> {
    pub(super) root: Value<'a>,
    pub(super) accessors: Array<'a>,
    pub(super) buffer_views: Array<'a>,
    pub(super) buffers: Array<'a>,
    pub(super) cameras: Array<'a>,
    pub(super) images: Array<'a>,
    /// Of `KHR_lights_punctual`.
    pub(super) lights: Array<'a>,
    pub(super) materials: Array<'a>,
    pub(super) meshes: Array<'a>,
    pub(super) nodes: Array<'a>,
    pub(super) samplers: Array<'a>,
    pub(super) scenes: Array<'a>,
    pub(super) textures: Array<'a>,
}

impl<'a> Document<'a> {
    /// # Errors
    /// A version other than 2.x, or a member that should be an array and is not.
    pub(super) fn new(json: &'a Json) -> Result<Self> {
        let root = json.root();
        let asset = root.require("asset")?;
        let version = asset.require("version")?;
        if !version.text()?.starts_with("2.") {
            return Err(version.error("is not supported, only glTF 2"));
        }
        if let Some(least) = asset.get("minVersion")?
            && least.text()? != "2.0"
        {
            return Err(least.error("is not supported, only glTF 2.0"));
        }
        let array = |name| Array::new(Some(root), name);
        Ok(Self {
            root,
            accessors: array("accessors")?,
            buffer_views: array("bufferViews")?,
            buffers: array("buffers")?,
            cameras: array("cameras")?,
            images: array("images")?,
            lights: Array::new(root.extension("KHR_lights_punctual")?, "lights")?,
            materials: array("materials")?,
            meshes: array("meshes")?,
            nodes: array("nodes")?,
            samplers: array("samplers")?,
            scenes: array("scenes")?,
            textures: array("textures")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_and_references() {
        let text = br#"{"asset":{"version":"2.0"},"scene":1,"scenes":[{},{"name":"b"}],"nodes":[7]}"#;
        let json = Json::parse(text).unwrap();
        let document = Document::new(&json).unwrap();
        let (index, scene) = document.scenes.referred(document.root.require("scene").unwrap()).unwrap();
        assert_eq!((index, scene.path().as_str()), (1, "scenes[1]"));
        let bad = document.nodes.at(0).unwrap();
        let e = document.scenes.referred(bad).err().unwrap().to_string();
        assert_eq!(e, "nodes[0]: 7 is out of range, the file has 2 scenes");
    }

    #[test]
    fn other_versions_are_refused() {
        for text in [
            r#"{}"#,
            r#"[]"#,
            r#"{"asset":{"version":"1.0"}}"#,
            r#"{"asset":{"version":"2.0","minVersion":"2.1"}}"#,
            r#"{"asset":{"version":"2.0"},"nodes":{}}"#,
        ] {
            let json = Json::parse(text.as_bytes()).unwrap();
            assert!(Document::new(&json).is_err(), "{text}");
        }
    }
}
