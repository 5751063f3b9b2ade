//! The one error type: a sentence for a person, and whether the command line itself was wrong.

use std::fmt;

/// What went wrong, as one sentence that names file, field and index where there are any.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    message: String,
    kind: ErrorKind,
}

/// Decides the exit status (DESIGN.md, section 6).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorKind {
    /// The work failed or a check found something: exit status 1.
    Failed,
    /// The command line cannot be carried out as written: exit status 2.
    Usage,
}

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An error of the work itself (exit status 1).
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), kind: ErrorKind::Failed }
    }

    /// An error of the command line (exit status 2).
    pub fn usage(message: impl Into<String>) -> Self {
        Self { message: message.into(), kind: ErrorKind::Usage }
    }

    /// The same error with `context` and a colon before it.
    pub fn within(self, context: impl fmt::Display) -> Self {
        Self { message: format!("{context}: {}", self.message), kind: self.kind }
    }

    /// Which exit status the error asks for.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Error {}
