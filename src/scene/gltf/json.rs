//! `serde_json`'s tree of a JSON text, with values that know their place in it.
//!
//! The tree costs many times its text, so [`tree_bytes`] bounds it before it is built (see [`super::budget`]). The
//! path of a value (`accessors[12].byteOffset`) is worked out only when a message needs it.

use std::fmt;

use serde_json::Value as Node;

use super::json_error::explain;
use crate::error::{Error, Result};

/// Deepest nesting that the parser takes; glTF needs about ten.
const MAX_DEPTH: usize = 128;

/// Longest piece of the file that a message repeats, in bytes.
const QUOTE_BYTES: usize = 64;

/// Most bytes that an allocator rounds up a small block by, its own notes included.
const BLOCK_BYTES: usize = 32;

/// A parsed text.
pub(super) struct Json {
    root: Node,
}

/// One value of a [`Json`].
#[derive(Clone, Copy)]
pub(super) struct Value<'a> {
    root: &'a Node,
    node: &'a Node,
}

/// `text` cut to a length that suits a message.
pub(super) fn shorten(text: &str) -> &str {
    let mut end = text.len().min(QUOTE_BYTES);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text[..end]
}

/// No fewer bytes than the tree of `text` takes, also while it is built.
///
/// While a container grows, the old and the new block stand side by side. A list has room for 4 elements from the
/// first one on and then for twice as many each time: at most 4 + 3 (n - 1) for n elements. An object has room for 3,
/// 7, 14 ... members: at most 3 n, and 60 bytes a member of its hash table. Outside strings, members are colons, and
/// the elements after the first of their list are the commas that no object has; an object has one comma fewer than
/// colons, so those are at most commas - colons + braces. A mark inside a string only adds, since a member costs more
/// than an element.
pub(super) fn tree_bytes(text: &[u8]) -> u64 {
    // Blocks: an element may be a string; a list has one itself; an object has two, and each member a name.
    const ELEMENT: u64 = (3 * size_of::<Node>() + BLOCK_BYTES) as u64;
    const FIRST: u64 = (4 * size_of::<Node>() + 2 * BLOCK_BYTES) as u64;
    const MEMBER: u64 = (3 * size_of::<(usize, String, Node)>() + 60 + 4 * BLOCK_BYTES) as u64;
    let (mut colons, mut brackets, mut others) = (0_u64, 0_u64, 0_u64);
    for byte in text {
        match byte {
            b':' => colons += 1,
            b'[' => brackets += 1,
            b',' | b'{' => others += 1,
            _ => {}
        }
    }
    text.len() as u64 + colons * (MEMBER - ELEMENT) + brackets * FIRST + others * ELEMENT
}

impl Json {
    /// Parses `bytes` (UTF-8, with or without a byte order mark). Of members with one name the last counts.
    ///
    /// # Errors
    /// Text that is not JSON, or nested too deeply, with the field, line and column where that shows.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self> {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF".as_slice()).unwrap_or(bytes);
        match serde_json::from_slice(bytes) {
            Ok(root) => Ok(Self { root }),
            Err(e) => Err(explain(bytes, &e)),
        }
    }

    /// The outermost value.
    pub(super) fn root(&self) -> Value<'_> {
        Value { root: &self.root, node: &self.root }
    }
}

impl<'a> Value<'a> {
    fn at(self, node: &'a Node) -> Self {
        Self { root: self.root, node }
    }

    /// The member called `key`; `None` where there is none or it is `null`.
    ///
    /// # Errors
    /// This value is not an object.
    pub(super) fn get(self, key: &str) -> Result<Option<Self>> {
        let members = self.node.as_object().ok_or_else(|| self.error("is not an object"))?;
        Ok(members.get(key).filter(|node| !node.is_null()).map(|node| self.at(node)))
    }

    /// The member called `key`, which must be there.
    pub(super) fn require(self, key: &str) -> Result<Self> {
        self.get(key)?.ok_or_else(|| self.error(format_args!("has no {key}")))
    }

    /// The member of the member called `extensions`, where there is one.
    pub(super) fn extension(self, name: &str) -> Result<Option<Self>> {
        match self.get("extensions")? {
            Some(extensions) => extensions.get(name),
            None => Ok(None),
        }
    }

    /// The member called `lampyris` of `extras`, which of other programs may be anything.
    pub(super) fn own_extras(self) -> Result<Option<Self>> {
        match self.get("extras")? {
            Some(extras) if extras.node.is_object() => extras.get("lampyris"),
            _ => Ok(None),
        }
    }

    /// Members of an object that are none of `known`.
    pub(super) fn unknown_members(self, known: &[&str]) -> u64 {
        let members = self.node.as_object().into_iter().flatten();
        members.filter(|(key, _)| !known.contains(&key.as_str())).count() as u64
    }

    /// Elements of an array.
    pub(super) fn elements(self) -> Result<impl ExactSizeIterator<Item = Self> + use<'a>> {
        let list = self.node.as_array().ok_or_else(|| self.error("is not an array"))?;
        Ok(list.iter().map(move |node| self.at(node)))
    }

    /// Element `index` of an array, where there is one.
    pub(super) fn element(self, index: usize) -> Option<Self> {
        self.node.get(index).map(|node| self.at(node))
    }

    /// A string.
    pub(super) fn text(self) -> Result<&'a str> {
        self.node.as_str().ok_or_else(|| self.error("is not a string"))
    }

    /// A short string for messages and names: the member called `name`, or `otherwise`.
    pub(super) fn name_or(self, otherwise: impl FnOnce() -> String) -> Result<String> {
        Ok(match self.get("name")? {
            Some(name) if !name.text()?.is_empty() => shorten(name.text()?).to_owned(),
            _ => otherwise(),
        })
    }

    /// A number; all that the parser takes are finite.
    pub(super) fn number(self) -> Result<f64> {
        self.node.as_f64().ok_or_else(|| self.error("is not a number"))
    }

    /// A number that is finite as f32 too.
    pub(super) fn float(self) -> Result<f32> {
        let number = self.number()?;
        let float = number as f32;
        if float.is_finite() {
            return Ok(float);
        }
        Err(self.error(format_args!("{number:e} is not a finite number in 32 bits")))
    }

    /// Exactly `N` numbers that are finite as f32 too.
    pub(super) fn floats<const N: usize>(self) -> Result<[f32; N]> {
        Ok(self.numbers::<N>()?.map(|number| number as f32))
    }

    /// Exactly `N` numbers in all their digits, finite as f32 too.
    pub(super) fn numbers<const N: usize>(self) -> Result<[f64; N]> {
        let elements = self.elements()?;
        let count = elements.len();
        let mut numbers = [0.0; N];
        for (slot, element) in numbers.iter_mut().zip(elements) {
            element.float()?;
            *slot = element.number()?;
        }
        if count == N { Ok(numbers) } else { Err(self.error(format_args!("has {count} numbers instead of {N}"))) }
    }

    /// A whole number from 0 to 2^53, also when written as `3.0`.
    pub(super) fn index(self) -> Result<usize> {
        let number = self.number()?;
        if let Some(index) = self.node.as_u64().and_then(|index| usize::try_from(index).ok()) {
            return Ok(index);
        }
        if (0.0..=9.0e15).contains(&number) && number.fract() == 0.0 {
            return Ok(number as usize);
        }
        Err(self.error(format_args!("{} is not a whole number from 0 on", self.node)))
    }

    /// One of OpenGL's numbers, by which glTF names types, modes and filters.
    pub(super) fn code(self) -> Result<u32> {
        let index = self.index()?;
        u32::try_from(index).map_err(|_| self.error(format_args!("{index} does not fit 32 bits")))
    }

    /// `true` or `false`.
    pub(super) fn boolean(self) -> Result<bool> {
        self.node.as_bool().ok_or_else(|| self.error("is neither true nor false"))
    }

    /// Where the value stands, as `nodes[3].rotation`.
    pub(super) fn path(self) -> String {
        let mut path = String::new();
        // Messages are mostly about values near the root, so those are looked at first.
        let _ = (0..=MAX_DEPTH).any(|depth| find(self.root, self.node, depth, &mut path));
        match path.strip_prefix('.').unwrap_or(&path) {
            "" => "the outermost value".into(),
            path => path.into(),
        }
    }

    /// `path: what`.
    pub(super) fn error(self, what: impl fmt::Display) -> Error {
        Error::new(format!("{}: {what}", self.path()))
    }
}

/// The value's path.
impl fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.path())
    }
}

/// Puts the steps from `at` down to the very node `target` before `path`; false where it is not within `depth` steps.
fn find(at: &Node, target: &Node, depth: usize, path: &mut String) -> bool {
    if std::ptr::eq(at, target) {
        return true;
    }
    let Some(depth) = depth.checked_sub(1) else {
        return false;
    };
    let step = match at {
        Node::Array(list) => {
            list.iter().position(|node| find(node, target, depth, path)).map(|index| format!("[{index}]"))
        }
        Node::Object(members) => members
            .iter()
            .find(|(_, node)| find(node, target, depth, path))
            .map(|(name, _)| format!(".{}", shorten(name))),
        _ => None,
    };
    let Some(step) = step else {
        return false;
    };
    path.insert_str(0, &step);
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        r#"{"a":[1,{"b":"x\u00e9\n\ud83d\ude00","c":null}],"d":{"e":-1.5e2,"f":true,"g":3.0,"h":1e39},"i":[],"e":0}"#;

    #[test]
    fn values_are_found_and_named() {
        let json = Json::parse(TEXT.as_bytes()).unwrap();
        let root = json.root();
        let a = root.require("a").unwrap();
        let second = a.elements().unwrap().nth(1).unwrap();
        let b = second.require("b").unwrap();
        assert_eq!(b.text().unwrap(), "x\u{e9}\n\u{1F600}");
        assert_eq!((b.path().as_str(), root.path().as_str()), ("a[1].b", "the outermost value"));
        assert_eq!(a.element(1).unwrap().path(), "a[1]");
        assert!(second.get("c").unwrap().is_none() && a.element(2).is_none());
        let d = root.require("d").unwrap();
        assert_eq!(d.require("e").unwrap().number().unwrap(), -150.0);
        assert_eq!(d.require("e").unwrap().path(), "d.e");
        assert!(d.require("f").unwrap().boolean().unwrap());
        assert_eq!(d.require("g").unwrap().index().unwrap(), 3);
        let e = d.require("h").unwrap().float().unwrap_err().to_string();
        assert_eq!(e, "d.h: 1e39 is not a finite number in 32 bits");
        assert_eq!(root.require("i").unwrap().elements().unwrap().count(), 0);
        assert_eq!(d.require("z").err().unwrap().to_string(), "d: has no z");
        assert_eq!(a.floats::<3>().unwrap_err().to_string(), "a[1]: is not a number");
        assert_eq!(root.require("i").unwrap().floats::<2>().unwrap_err().to_string(), "i: has 0 numbers instead of 2");
    }

    #[test]
    fn wrong_kinds_are_refused() {
        let json = Json::parse(br#"{"n":-1,"f":0.5,"big":4294967296,"n\u0061":[0,1]}"#).unwrap();
        let root = json.root();
        let n = root.require("n").unwrap();
        assert_eq!(n.index().unwrap_err().to_string(), "n: -1 is not a whole number from 0 on");
        assert!(root.require("f").unwrap().index().is_err());
        assert!(n.get("x").is_err() && n.text().is_err() && n.boolean().is_err());
        assert!(root.elements().is_err() && root.element(0).is_none());
        let big = root.require("big").unwrap();
        assert_eq!(big.index().unwrap(), 1 << 32);
        assert_eq!(big.code().unwrap_err().to_string(), "big: 4294967296 does not fit 32 bits");
        assert_eq!(root.require("na").unwrap().elements().unwrap().len(), 2);
    }

    #[test]
    fn the_last_of_equal_names_counts() {
        let json = Json::parse(b"\xEF\xBB\xBF{\"a\":1,\"b\":2,\"a\":3}").unwrap();
        assert_eq!(json.root().require("a").unwrap().index().unwrap(), 3);
    }

    /// Bytes that a node's blocks take, but for hash tables and what allocators add.
    fn block_bytes(node: &Node) -> usize {
        match node {
            Node::String(text) => text.capacity(),
            Node::Array(list) => list.capacity() * size_of::<Node>() + list.iter().map(block_bytes).sum::<usize>(),
            Node::Object(members) => {
                let room = if members.is_empty() { 0 } else { members.len().max(3) };
                let inside = members.iter().map(|(name, node)| name.len() + block_bytes(node)).sum::<usize>();
                room * size_of::<(usize, String, Node)>() + inside
            }
            _ => 0,
        }
    }

    #[test]
    fn the_tree_takes_no_more_than_was_said() {
        for piece in [
            "[]",
            "{}",
            "0",
            "\"\"",
            "[0]",
            "[[[[0]]]]",
            "[0,0,0,0,0]",
            "{\"\":0}",
            "{\"a\":{\"b\":[{\"c\":\"d\"}]}}",
            "{\"a\":0,\"b\":1,\"c\":2,\"d\":3}",
            "\"[[::,,{{::::\"",
        ] {
            for count in [1, 4, 5, 1025] {
                let text = format!("[{}]", vec![piece; count].join(","));
                let (said, json) = (tree_bytes(text.as_bytes()), Json::parse(text.as_bytes()).unwrap());
                let taken = block_bytes(&json.root) as u64;
                assert!(taken <= said, "{count} of {piece}: {taken} bytes, {said} said");
            }
        }
    }
}
