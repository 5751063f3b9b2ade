//! The one pass over a JSON text (RFC 8259) that finds where every value begins and ends.

use crate::error::{Error, Result};

/// Deepest nesting, as serde_json has it; glTF needs about ten.
const MAX_DEPTH: usize = 128;

/// A value of the text; names of members count as values before the value they name.
#[derive(Debug, Clone, Copy)]
pub(super) struct Token {
    /// Byte of the text.
    pub(super) start: u32,
    /// Number of the first token that is neither this one nor inside it.
    pub(super) next: u32,
}

struct Scanner<'a> {
    text: &'a str,
    at: usize,
    tokens: Vec<Token>,
    open: Vec<Open>,
}

/// A container that has not been closed.
#[derive(Clone, Copy)]
struct Open {
    token: usize,
    close: u8,
    empty: bool,
}

/// All tokens of `text`, the outermost value first.
///
/// # Errors
/// Anything that is not one JSON value, and texts of 4 GiB and more.
pub(super) fn scan(text: &str) -> Result<Vec<Token>> {
    if u32::try_from(text.len()).is_err() {
        return Err(Error::new("the JSON text is larger than 4 GiB"));
    }
    // Each token but the first follows one of these, and every token but a bracket has a byte of its own beside it.
    let marks = text.bytes().filter(|b| matches!(b, b',' | b':' | b'[' | b'{')).count() + 1;
    let capacity = marks.min(text.len() / 2 + MAX_DEPTH);
    let mut scanner = Scanner { text, at: 0, tokens: Vec::with_capacity(capacity), open: Vec::new() };
    scanner.run()?;
    Ok(scanner.tokens)
}

impl Scanner<'_> {
    fn run(&mut self) -> Result<()> {
        self.begin_value()?;
        while let Some(open) = self.open.last().copied() {
            let byte = self.peek()?;
            if byte == open.close {
                self.at += 1;
                self.tokens[open.token].next = self.tokens.len() as u32;
                self.open.pop();
                continue;
            }
            if !open.empty {
                self.expect(b',')?;
            }
            if let Some(open) = self.open.last_mut() {
                open.empty = false;
            }
            if open.close == b'}' {
                if self.peek()? != b'"' {
                    return Err(self.error("a member's name in quotes should stand"));
                }
                self.push_token();
                self.string()?;
                self.expect(b':')?;
            }
            self.begin_value()?;
        }
        self.skip_space();
        if self.at < self.text.len() { Err(self.error("the JSON text should end")) } else { Ok(()) }
    }

    fn begin_value(&mut self) -> Result<()> {
        let byte = self.peek()?;
        let token = self.push_token();
        match byte {
            b'{' | b'[' => {
                if self.open.len() == MAX_DEPTH {
                    return Err(Error::new(format!("the JSON text is nested deeper than {MAX_DEPTH}")));
                }
                self.at += 1;
                let close = if byte == b'{' { b'}' } else { b']' };
                self.open.push(Open { token, close, empty: true });
                Ok(())
            }
            b'"' => self.string(),
            b't' => self.word("true"),
            b'f' => self.word("false"),
            b'n' => self.word("null"),
            b'-' | b'0'..=b'9' => self.number(),
            _ => Err(self.error("a value should stand")),
        }
    }

    fn push_token(&mut self) -> usize {
        let token = self.tokens.len();
        self.tokens.push(Token { start: self.at as u32, next: token as u32 + 1 });
        token
    }

    fn skip_space(&mut self) {
        let bytes = self.text.as_bytes();
        while self.at < bytes.len() && matches!(bytes[self.at], b' ' | b'\t' | b'\n' | b'\r') {
            self.at += 1;
        }
    }

    /// The next byte that is not white space.
    fn peek(&mut self) -> Result<u8> {
        self.skip_space();
        let byte = self.text.as_bytes().get(self.at).copied();
        byte.ok_or_else(|| Error::new("the JSON text ends too early"))
    }

    fn expect(&mut self, byte: u8) -> Result<()> {
        if self.peek()? != byte {
            return Err(self.error(&format!("'{}' should stand", byte as char)));
        }
        self.at += 1;
        Ok(())
    }

    fn word(&mut self, word: &str) -> Result<()> {
        if !self.text.as_bytes()[self.at..].starts_with(word.as_bytes()) {
            return Err(self.error("a value should stand"));
        }
        self.at += word.len();
        Ok(())
    }

    fn number(&mut self) -> Result<()> {
        let bytes = &self.text.as_bytes()[self.at..];
        let sign = usize::from(bytes[0] == b'-');
        let digits = |from: usize| bytes[from.min(bytes.len())..].iter().take_while(|b| b.is_ascii_digit()).count();
        let mut end = sign + digits(sign);
        let mut good = end > sign;
        if bytes.get(end) == Some(&b'.') {
            let count = digits(end + 1);
            good &= count > 0;
            end += 1 + count;
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let signed = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let count = digits(end + 1 + signed);
            good &= count > 0;
            end += 1 + signed + count;
        }
        // What follows is checked as the container's next byte; a second sign or point would be taken for the number's.
        if !good || matches!(bytes.get(end), Some(b'+' | b'-' | b'.' | b'e' | b'E')) {
            return Err(self.error("a number should stand"));
        }
        self.at += end;
        Ok(())
    }

    fn string(&mut self) -> Result<()> {
        let bytes = self.text.as_bytes();
        let mut at = self.at + 1;
        loop {
            match bytes.get(at) {
                Some(b'"') => break,
                Some(b'\\') => at += 2,
                Some(0..=0x1F) => {
                    return Err(Error::new(format!("the JSON text has a control character at byte {at}")));
                }
                Some(_) => at += 1,
                None => return Err(Error::new("the JSON text ends inside a string")),
            }
        }
        self.at = at + 1;
        Ok(())
    }

    fn error(&self, expected: &str) -> Error {
        Error::new(format!("byte {} of the JSON text: {expected} there", self.at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn good_texts() {
        for (text, tokens) in [
            ("0", 1),
            (" [ ] ", 1),
            ("{\"a\":1}", 3),
            ("[1,-2.5e-3,\"x\\\"y\",true,false,null]", 7),
            ("[[],{\"\":{}}]", 5),
        ] {
            assert_eq!(scan(text).unwrap().len(), tokens, "{text}");
        }
        assert!(scan(&format!("{}{}", "[".repeat(128), "]".repeat(128))).is_ok());
    }

    #[test]
    fn bad_texts() {
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
            "nan",
            "}",
        ] {
            assert!(scan(text).is_err(), "{text}");
        }
        assert!(scan(&"[".repeat(1000)).unwrap_err().to_string().contains("deeper than 128"));
    }
}
