//! What commands that measure share: a bar while they run, where results come from, and results as text and as files.

use std::io::IsTerminal;
use std::path::Path;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::error::{Error, Result};
use crate::measure::file;
use crate::measure::html::Section;
use crate::measure::plot::Figure;

/// Size of figures in files, pixels.
const FIGURE: (u32, u32) = (900, 540);

/// A progress bar on a terminal, nothing in a pipe.
pub fn progress(total: u64, what: &'static str) -> ProgressBar {
    let target =
        if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(total), target).with_message(what);
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar
}

/// The command line, without the program's name.
pub fn typed_arguments() -> Vec<String> {
    std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()).collect()
}

/// Cores that this process may use.
pub fn host_cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Makes a folder for results, before the work that fills it.
///
/// # Errors
/// No permission, or a file in its place.
pub fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::new(format!("{} could not be made: {e}", folder.display())))
}

/// Writes figures into a folder: `NAME.svg` and `NAME.png`, a second figure as `NAME-2`. PNG files say where they come from.
///
/// # Errors
/// See [`file::write`].
pub fn write_figures(folder: &Path, name: &str, figures: &[Figure], origin: &[(String, String)]) -> Result<()> {
    let notes: Vec<_> = origin.iter().map(|(key, value)| (format!("lampyris {key}"), value.clone())).collect();
    for (index, figure) in figures.iter().enumerate() {
        let name = if index == 0 { name.to_string() } else { format!("{name}-{}", index + 1) };
        file::write(&folder.join(format!("{name}.svg")), figure.svg(FIGURE)?.as_bytes())?;
        file::write(&folder.join(format!("{name}.png")), &figure.png(FIGURE, &notes)?)?;
    }
    Ok(())
}

/// A part of a report for a terminal: tables, then paragraphs and notes.
pub fn text(section: &Section, notes: &[String]) -> String {
    let tables = section.tables.iter().map(|table| table.text() + "\n");
    let remarks = section.paragraphs.iter().cloned().chain(numbered(notes)).map(|line| line + "\n");
    format!("\n{}\n\n{}{}", section.title, tables.collect::<String>(), remarks.collect::<String>())
}

/// Sentences by the numbers that stand in tables.
pub fn numbered(notes: &[String]) -> Vec<String> {
    notes.iter().enumerate().map(|(index, note)| format!("[{}] {note}", index + 1)).collect()
}

/// What stands in a table where there is no number: the number of the sentence in `notes`, which equal ones share.
pub fn refused(sentence: &str, notes: &mut Vec<String>) -> String {
    let known = notes.iter().position(|note| note == sentence);
    let index = known.unwrap_or_else(|| {
        notes.push(sentence.to_string());
        notes.len() - 1
    });
    format!("refused [{}]", index + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_sentences_share_a_number() {
        let mut notes = Vec::new();
        assert_eq!(["a", "b", "a"].map(|why| refused(why, &mut notes)), ["refused [1]", "refused [2]", "refused [1]"]);
        assert_eq!(numbered(&notes), ["[1] a", "[2] b"]);
    }

    #[test]
    fn text_has_the_title_first_and_notes_last() {
        let section = Section { title: "tiles".into(), paragraphs: vec!["How.".into()], ..Section::default() };
        assert_eq!(text(&section, &["why".into()]), "\ntiles\n\nHow.\n[1] why\n");
    }
}
