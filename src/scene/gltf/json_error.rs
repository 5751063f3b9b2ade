//! Where a text stops being JSON: the parser says line and column, a person looks for the field.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};

use super::json::shorten;
use crate::error::Error;

/// The sentence for a text that the parser refuses with `error`.
pub(super) fn explain(text: &[u8], error: &serde_json::Error) -> Error {
    if error.is_eof() {
        return Error::new("the JSON text ends too early");
    }
    let mut path = String::new();
    // Fails where the text failed before, or not at all where something follows the outermost value.
    let _ = Reading { path: &mut path }.deserialize(&mut serde_json::Deserializer::from_slice(text));
    let place = match path.strip_prefix('.').unwrap_or(&path) {
        "" => "the JSON text",
        path => shorten(path),
    };
    Error::new(format!("{place}: {error}"))
}

/// Reads a value, keeps nothing of it, and leaves in `path` where it failed.
struct Reading<'p> {
    path: &'p mut String,
}

impl<'de> DeserializeSeed<'de> for Reading<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, text: D) -> Result<(), D::Error> {
        text.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Reading<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let length = self.path.len();
        for index in 0_usize.. {
            self.path.push_str(&format!("[{index}]"));
            let element = list.next_element_seed(Reading { path: self.path })?;
            self.path.truncate(length);
            if element.is_none() {
                break;
            }
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<(), A::Error> {
        let length = self.path.len();
        while let Some(key) = members.next_key::<String>()? {
            self.path.push_str(&format!(".{}", shorten(&key)));
            members.next_value_seed(Reading { path: self.path })?;
            self.path.truncate(length);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::json::Json;

    #[test]
    fn the_field_is_named() {
        for (text, start) in [
            ("{\"a\":[{},{\"b\":1e999}]}", "a[1].b: number out of range at line 1 column "),
            ("[0,{\"a\":{\"b\":-}}]", "[1].a.b: invalid number at line 1 column "),
            ("{\"a\":\n\"\\x\"}", "a: invalid escape at line 2 column "),
            ("[1]2", "the JSON text: trailing characters at line 1 column "),
            ("nan", "the JSON text: expected ident at line 1 column "),
            ("{\"a\":[1", "the JSON text ends too early"),
        ] {
            let e = Json::parse(text.as_bytes()).err().unwrap().to_string();
            assert!(e.starts_with(start), "{text}: {e}");
        }
    }

    #[test]
    fn texts_that_are_not_json() {
        for text in [
            "",
            "[",
            "[1",
            "[1,]",
            "[,1]",
            "{\"a\"}",
            "{\"a\":}",
            "{a:1}",
            "[1 2]",
            "01x",
            "1.",
            "-",
            "1e",
            "1-2",
            "tru",
            "\"",
            "\"\\\"",
            "[1]2",
            "\"\u{1}\"",
            "\"\\ud800\"",
            "}",
        ] {
            assert!(Json::parse(text.as_bytes()).is_err(), "{text}");
        }
        assert!(Json::parse(b"\"\xFF\"").is_err());
        let nested = |depth: usize| format!("{}{}", "[".repeat(depth), "]".repeat(depth));
        assert!(Json::parse(nested(100).as_bytes()).is_ok());
        let e = Json::parse(nested(100_000).as_bytes()).err().unwrap().to_string();
        assert!(e.contains("recursion limit exceeded"), "{e}");
    }
}
