//! A JSON text kept as it is, with eight bytes a value that say where it begins and where the next one is.
//!
//! A tree of owned values costs 30 to 300 bytes for the three bytes of `{},`; this list costs at most four bytes a byte
//! of text, so the loader's memory bound (see [`super::budget`]) holds for any text. Numbers and strings are read when
//! they are asked for, and the path of a value (`accessors[12].byteOffset`) is worked out only when an error needs it.

use std::borrow::Cow;
use std::fmt;

use super::json_scan::{Token, scan};
use crate::error::{Error, Result};

/// Longest object that is searched: no glTF object has a tenth of this many members, and a search is linear.
const MAX_MEMBERS: usize = 256;

/// Longest piece of the file that a message repeats, in bytes.
const QUOTE_BYTES: usize = 64;

/// A scanned text.
pub(super) struct Json<'a> {
    text: &'a str,
    tokens: Vec<Token>,
}

/// One value of a [`Json`].
#[derive(Clone, Copy)]
pub(super) struct Value<'a> {
    json: &'a Json<'a>,
    token: u32,
}

/// `text` cut to a length that suits a message.
pub(super) fn shorten(text: &str) -> &str {
    let mut end = text.len().min(QUOTE_BYTES);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text[..end]
}

impl<'a> Json<'a> {
    /// Checks the whole of `bytes` (UTF-8, with or without a byte order mark).
    ///
    /// # Errors
    /// Text that is not JSON, or nested deeper than 128, with the byte where that shows.
    pub(super) fn parse(bytes: &'a [u8]) -> Result<Self> {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF".as_slice()).unwrap_or(bytes);
        let text = std::str::from_utf8(bytes)
            .map_err(|e| Error::new(format!("the JSON text is not UTF-8 at byte {}", e.valid_up_to())))?;
        Ok(Self { text, tokens: scan(text)? })
    }

    /// The outermost value.
    pub(super) fn root(&'a self) -> Value<'a> {
        Value { json: self, token: 0 }
    }

    /// The value at a number that [`Value::id`] gave.
    pub(super) fn value(&'a self, id: u32) -> Value<'a> {
        Value { json: self, token: id }
    }
}

impl<'a> Value<'a> {
    /// A number that stands for this value in its [`Json`].
    pub(super) fn id(self) -> u32 {
        self.token
    }

    fn start(self) -> usize {
        self.json.tokens[self.token as usize].start as usize
    }

    /// The value after this one, wherever that is.
    fn skip(self) -> Self {
        Self { json: self.json, token: self.json.tokens[self.token as usize].next }
    }

    fn first_inside(self) -> Self {
        Self { json: self.json, token: self.token + 1 }
    }

    /// The text from this value's first byte on.
    fn rest(self) -> &'a str {
        &self.json.text[self.start()..]
    }

    fn first_byte(self) -> u8 {
        self.json.text.as_bytes()[self.start()]
    }

    fn is_null(self) -> bool {
        self.first_byte() == b'n'
    }

    /// The bytes between a string's quotes, escapes as written.
    fn raw_string(self) -> &'a str {
        let inside = &self.rest()[1..];
        let bytes = inside.as_bytes();
        let mut end = 0;
        while end < bytes.len() && bytes[end] != b'"' {
            end += if bytes[end] == b'\\' { 2 } else { 1 };
        }
        inside.get(..end).unwrap_or(inside)
    }

    fn is_key(self, key: &str) -> bool {
        self.rest()[1..].strip_prefix(key).is_some_and(|rest| rest.starts_with('"'))
    }

    /// The member called `key`; `None` where there is none or it is `null`.
    ///
    /// # Errors
    /// This value is not an object, or has more than 256 members.
    pub(super) fn get(self, key: &str) -> Result<Option<Self>> {
        for (count, (name, value)) in self.members()?.enumerate() {
            if count == MAX_MEMBERS {
                return Err(self.error(format_args!("has more than {MAX_MEMBERS} members")));
            }
            if name.is_key(key) {
                return Ok((!value.is_null()).then_some(value));
            }
        }
        Ok(None)
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

    /// Names and values of an object, in the text's order.
    pub(super) fn members(self) -> Result<impl Iterator<Item = (Self, Self)> + use<'a>> {
        if self.first_byte() != b'{' {
            return Err(self.error("is not an object"));
        }
        let end = self.skip().token;
        let mut at = self.first_inside();
        Ok(std::iter::from_fn(move || {
            (at.token < end).then(|| {
                let name = at;
                let value = name.skip();
                at = value.skip();
                (name, value)
            })
        }))
    }

    /// Elements of an array.
    pub(super) fn elements(self) -> Result<impl Iterator<Item = Self> + use<'a>> {
        if self.first_byte() != b'[' {
            return Err(self.error("is not an array"));
        }
        let end = self.skip().token;
        let mut at = self.first_inside();
        Ok(std::iter::from_fn(move || {
            (at.token < end).then(|| {
                let value = at;
                at = value.skip();
                value
            })
        }))
    }

    /// A string with its escapes resolved.
    pub(super) fn text(self) -> Result<Cow<'a, str>> {
        if self.first_byte() != b'"' {
            return Err(self.error("is not a string"));
        }
        let raw = self.raw_string();
        if !raw.contains('\\') {
            return Ok(Cow::Borrowed(raw));
        }
        unescape(raw).map(Cow::Owned).ok_or_else(|| self.error("has an escape that is not JSON's"))
    }

    /// A short string for messages and names: the member called `name`, or `otherwise`.
    pub(super) fn name_or(self, otherwise: impl FnOnce() -> String) -> Result<String> {
        Ok(match self.get("name")? {
            Some(name) if !name.text()?.is_empty() => shorten(&name.text()?).to_owned(),
            _ => otherwise(),
        })
    }

    fn number_text(self) -> Result<&'a str> {
        let rest = self.rest();
        let end = rest.bytes().position(|b| !b.is_ascii_digit() && !matches!(b, b'+' | b'-' | b'.' | b'e' | b'E'));
        let text = &rest[..end.unwrap_or(rest.len())];
        if text.is_empty() { Err(self.error("is not a number")) } else { Ok(text) }
    }

    /// A finite number.
    pub(super) fn number(self) -> Result<f64> {
        let text = self.number_text()?;
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.error(format_args!("{} is not a finite number", shorten(text)))),
        }
    }

    /// A number that is finite as f32 too.
    pub(super) fn float(self) -> Result<f32> {
        let number = self.number()? as f32;
        if number.is_finite() {
            return Ok(number);
        }
        Err(self.error(format_args!("{} is not a finite number in 32 bits", shorten(self.number_text()?))))
    }

    /// Exactly `N` numbers.
    pub(super) fn floats<const N: usize>(self) -> Result<[f32; N]> {
        let mut floats = [0.0; N];
        let mut count = 0;
        for element in self.elements()? {
            if let Some(slot) = floats.get_mut(count) {
                *slot = element.float()?;
            }
            count += 1;
        }
        if count == N { Ok(floats) } else { Err(self.error(format_args!("has {count} numbers instead of {N}"))) }
    }

    /// A whole number from 0 to 2^53, also when written as `3.0`.
    pub(super) fn index(self) -> Result<usize> {
        let text = self.number_text()?;
        if let Ok(index) = text.parse::<usize>() {
            return Ok(index);
        }
        match self.number()? {
            number if (0.0..=9.0e15).contains(&number) && number.fract() == 0.0 => Ok(number as usize),
            _ => Err(self.error(format_args!("{} is not a whole number from 0 on", shorten(text)))),
        }
    }

    /// `true` or `false`.
    pub(super) fn boolean(self) -> Result<bool> {
        match self.first_byte() {
            b't' => Ok(true),
            b'f' => Ok(false),
            _ => Err(self.error("is neither true nor false")),
        }
    }

    /// Where the value stands, as `nodes[3].rotation`.
    pub(super) fn path(self) -> String {
        let mut path = String::new();
        let mut at = self.json.root();
        while at.token < self.token {
            let is_object = at.first_byte() == b'{';
            let (mut child, mut position) = (at.first_inside(), 0);
            let mut name = child;
            loop {
                if is_object {
                    name = child;
                    child = name.skip();
                }
                if child.skip().token > self.token {
                    break;
                }
                child = child.skip();
                position += 1;
            }
            if is_object {
                let dot = if path.is_empty() { "" } else { "." };
                path.push_str(&format!("{dot}{}", shorten(name.raw_string())));
            } else {
                path.push_str(&format!("[{position}]"));
            }
            at = child;
        }
        if path.is_empty() { "the outermost value".into() } else { path }
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

/// RFC 8259, section 7; `None` for an escape it does not have, or half a surrogate pair.
fn unescape(raw: &str) -> Option<String> {
    let mut text = String::with_capacity(raw.len());
    let mut rest = raw;
    while let Some(at) = rest.find('\\') {
        text.push_str(&rest[..at]);
        let escape = *rest.as_bytes().get(at + 1)?;
        rest = rest.get(at + 2..)?;
        match escape {
            b'"' | b'\\' | b'/' => text.push(escape as char),
            b'b' => text.push('\u{8}'),
            b'f' => text.push('\u{c}'),
            b'n' => text.push('\n'),
            b'r' => text.push('\r'),
            b't' => text.push('\t'),
            b'u' => {
                let (unit, after) = code_unit(rest)?;
                rest = after;
                if (0xD800..0xDC00).contains(&unit) {
                    let (low, after) = code_unit(rest.strip_prefix("\\u")?)?;
                    rest = after;
                    let low = low.checked_sub(0xDC00).filter(|low| *low < 0x400)?;
                    text.push(char::from_u32(0x1_0000 + ((unit - 0xD800) << 10) + low)?);
                } else {
                    text.push(char::from_u32(unit)?);
                }
            }
            _ => return None,
        }
    }
    text.push_str(rest);
    Some(text)
}

fn code_unit(text: &str) -> Option<(u32, &str)> {
    let digits = text.get(..4)?;
    if !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    Some((u32::from_str_radix(digits, 16).ok()?, &text[4..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        r#"{"a":[1,{"b":"x\u00e9\n\ud83d\ude00","c":null}],"d":{"e":-1.5e2,"f":true,"g":3.0,"h":1e999},"i":[]}"#;

    #[test]
    fn values_are_found_and_named() {
        let json = Json::parse(TEXT.as_bytes()).unwrap();
        let root = json.root();
        let a = root.require("a").unwrap();
        let second = a.elements().unwrap().nth(1).unwrap();
        let b = second.require("b").unwrap();
        assert_eq!(b.text().unwrap(), "x\u{e9}\n\u{1F600}");
        assert_eq!(b.path(), "a[1].b");
        assert!(second.get("c").unwrap().is_none());
        let d = root.require("d").unwrap();
        assert_eq!(d.require("e").unwrap().number().unwrap(), -150.0);
        assert!(d.require("f").unwrap().boolean().unwrap());
        assert_eq!(d.require("g").unwrap().index().unwrap(), 3);
        let e = d.require("h").unwrap().number().unwrap_err().to_string();
        assert_eq!(e, "d.h: 1e999 is not a finite number");
        assert_eq!(root.require("i").unwrap().elements().unwrap().count(), 0);
        assert_eq!(d.require("z").err().unwrap().to_string(), "d: has no z");
        assert_eq!(a.floats::<3>().unwrap_err().to_string(), "a[1]: is not a number");
    }

    #[test]
    fn wrong_kinds_are_refused() {
        let json = Json::parse(br#"{"s":"\x","n":-1,"half":"\ud800"}"#).unwrap();
        let root = json.root();
        assert!(root.require("s").unwrap().text().is_err());
        assert!(root.require("half").unwrap().text().is_err());
        assert!(root.require("n").unwrap().index().is_err());
        assert!(root.require("n").unwrap().get("x").is_err());
        assert!(root.elements().is_err());
        let many: String = (0..300).map(|i| format!("\"k{i}\":0,")).collect();
        let text = format!("{{{many}\"last\":1}}");
        let json = Json::parse(text.as_bytes()).unwrap();
        assert!(json.root().get("last").is_err());
        assert!(json.root().get("k7").unwrap().is_some());
    }
}
