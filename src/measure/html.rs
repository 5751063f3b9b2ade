//! Reports: tables for the terminal, and one self-contained page of tables, figures and pictures: no script, and nothing that is
//! fetched from elsewhere.

use base64::prelude::{BASE64_STANDARD, Engine};

use super::plot::Figure;
use crate::error::{Error, Result};

/// Size of figures on a page, in CSS pixels.
const FIGURE: (u32, u32) = (900, 540);

/// First bytes of a PNG file.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

const STYLE: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/report/report.css"));

/// A table of texts. Rows may be shorter than the header or longer.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// Cells, a row at a time.
    pub rows: Vec<Vec<String>>,
}

/// A part of a report: what an experiment gives.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Section {
    /// Heading.
    pub title: String,
    /// Text before the data.
    pub paragraphs: Vec<String>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Figures.
    pub figures: Vec<Figure>,
    /// Pictures: caption and PNG file.
    pub pictures: Vec<(String, Vec<u8>)>,
}

impl Table {
    /// The table for a terminal: columns as wide as their widest cell, those of numbers aligned to the right.
    pub fn text(&self) -> String {
        let columns = self.columns();
        let length = |cell: &str| cell.chars().count();
        let widths: Vec<usize> = (0..columns)
            .map(|column| self.lines().map(|row| length(&plain(cell(row, column)))).max().unwrap_or(0))
            .collect();
        let right: Vec<bool> = (0..columns).map(|column| self.is_numeric(column)).collect();
        let mut out = String::new();
        if !self.caption.is_empty() {
            out += &(plain(&self.caption) + "\n");
        }
        for (index, row) in self.lines().enumerate() {
            let mut line = String::new();
            for (column, (&width, &right)) in widths.iter().zip(&right).enumerate() {
                let text = plain(cell(row, column));
                line += &if right { format!("{text:>width$}  ") } else { format!("{text:<width$}  ") };
            }
            out += &(line.trim_end().to_string() + "\n");
            if index == 0 {
                out += &(widths.iter().map(|&width| "-".repeat(width)).collect::<Vec<_>>().join("  ") + "\n");
            }
        }
        out
    }

    fn columns(&self) -> usize {
        self.lines().map(|row| row.len()).max().unwrap_or(0)
    }

    /// The header, then the rows.
    fn lines(&self) -> impl Iterator<Item = &[String]> {
        std::iter::once(self.header.as_slice()).chain(self.rows.iter().map(Vec::as_slice))
    }

    /// Whether a column has numbers, and nothing else but cells that were not measured.
    fn is_numeric(&self, column: usize) -> bool {
        let cells = || self.rows.iter().map(move |row| cell(row, column)).filter(|text| !is_blank(text));
        cells().next().is_some() && cells().all(is_number)
    }

    fn html(&self, out: &mut String) {
        let right: Vec<&str> =
            (0..self.columns()).map(|column| if self.is_numeric(column) { " class=\"number\"" } else { "" }).collect();
        *out += "<div class=\"wide\"><table>\n";
        if !self.caption.is_empty() {
            *out += &format!("<caption>{}</caption>\n", escape(&self.caption));
        }
        for (index, row) in self.lines().enumerate() {
            let (before, tag, after) = match index {
                0 => ("<thead>", "th", "</thead>\n<tbody>"),
                _ => ("", "td", ""),
            };
            *out += &format!("{before}<tr>");
            for (column, class) in right.iter().enumerate() {
                *out += &format!("<{tag}{class}>{}</{tag}>", escape(cell(row, column)));
            }
            *out += &format!("</tr>{after}\n");
        }
        *out += "</tbody></table></div>\n";
    }
}

impl Section {
    fn html(&self, out: &mut String, index: usize) -> Result<()> {
        *out += &format!("<section id=\"part-{index}\">\n<h2>{}</h2>\n", escape(&self.title));
        for paragraph in &self.paragraphs {
            *out += &format!("<p>{}</p>\n", escape(paragraph));
        }
        for figure in &self.figures {
            let label = escape(&format!("{}. {}", figure.title(), figure.caption()));
            *out += &format!("<figure role=\"img\" aria-label=\"{label}\">\n{}</figure>\n", figure.svg(FIGURE)?);
        }
        for table in &self.tables {
            table.html(out);
        }
        for (caption, png) in &self.pictures {
            if !png.starts_with(PNG) {
                return Err(Error::new(format!("the report's picture \"{caption}\" is not a PNG file")));
            }
            let (caption, data) = (escape(caption), BASE64_STANDARD.encode(png));
            *out += &format!("<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\">");
            *out += &format!("<figcaption>{caption}</figcaption></figure>\n");
        }
        *out += "</section>\n";
        Ok(())
    }
}

/// One HTML page of all sections, with what is known of their origin (name, value) and a table of contents.
///
/// # Errors
/// A figure that cannot be drawn, or a picture that is not a PNG file.
pub fn page(title: &str, provenance: &[(String, String)], sections: &[Section]) -> Result<String> {
    let heading = escape(title);
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{heading}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{heading}</h1>\n"
    );
    if !provenance.is_empty() {
        out += "<dl>\n";
        for (name, value) in provenance {
            out += &format!("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(value));
        }
        out += "</dl>\n";
    }
    if sections.len() > 1 {
        out += "<nav><ol>\n";
        for (index, section) in sections.iter().enumerate() {
            out += &format!("<li><a href=\"#part-{index}\">{}</a></li>\n", escape(&section.title));
        }
        out += "</ol></nav>\n";
    }
    for (index, section) in sections.iter().enumerate() {
        section.html(&mut out, index)?;
    }
    Ok(out + "</body>\n</html>\n")
}

fn cell(row: &[String], column: usize) -> &str {
    row.get(column).map_or("", String::as_str)
}

fn is_blank(cell: &str) -> bool {
    matches!(cell.trim(), "" | "-" | "–" | "n/a")
}

/// Begins like a number, a bound or a difference: `12.5 ms`, `> 10 s`, `-3`.
fn is_number(cell: &str) -> bool {
    let unsigned = cell.trim_start_matches(['<', '>', '≤', '≥', '~', '±', '+', '-', '−', '.', ' ']);
    unsigned.starts_with(|c: char| c.is_ascii_digit()) || matches!(cell.trim(), "inf" | "NaN")
}

/// Text without what would move a terminal's cursor.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Text as HTML content or as a quoted attribute.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::plot::{Bars, Plot};

    fn strings(texts: &[&str]) -> Vec<String> {
        texts.iter().map(|text| text.to_string()).collect()
    }

    fn table() -> Table {
        Table {
            caption: "Frame times".into(),
            header: strings(&["technique", "ms", "note"]),
            rows: vec![
                strings(&["forward", "123.4", "a"]),
                strings(&["clustered", "> 9"]),
                strings(&["tiled", "n/a", "b"]),
            ],
        }
    }

    fn sections() -> Vec<Section> {
        let figures = vec![Figure::Plot(Plot::default()), Figure::Bars(Bars::default())];
        let png = figures[0].png((480, 300), &[]).expect("a PNG");
        let first = Section {
            title: "Lights & <more>".into(),
            paragraphs: strings(&["5 < 6"]),
            tables: vec![table()],
            figures,
            pictures: vec![("\"waste\"".into(), png)],
        };
        vec![first, Section { title: "Second".into(), ..Section::default() }]
    }

    #[test]
    fn text_is_aligned() {
        let expected = "Frame times\n\
                        technique     ms  note\n\
                        ---------  -----  ----\n\
                        forward    123.4  a\n\
                        clustered    > 9\n\
                        tiled        n/a  b\n";
        assert_eq!(table().text(), expected);
        assert_eq!(Table::default().text(), "\n\n");
    }

    #[test]
    fn columns_of_numbers_are_told() {
        let numeric: Vec<bool> = (0..4).map(|column| table().is_numeric(column)).collect();
        assert_eq!(numeric, [false, true, false, false]);
        for (text, expected) in [("-1.5", true), ("2 to 3", true), ("~5", true), ("minmax", false), ("off", false)] {
            assert_eq!(is_number(text), expected, "{text}");
        }
    }

    #[test]
    fn a_terminal_is_not_steered() {
        let table = Table { rows: vec![strings(&["\u{1b}[2J\n"])], ..Table::default() };
        assert!(!table.text().contains('\u{1b}'));
    }

    #[test]
    fn everything_is_escaped() {
        assert_eq!(escape("<a href=\"x\">'&\u{0}"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp; ");
        let page = page("<script>", &[("<i>".into(), "\"&\"".into())], &sections()).expect("a page");
        for (escaped, raw) in [
            ("&lt;script&gt;", "<script"),
            ("<dt>&lt;i&gt;</dt><dd>&quot;&amp;&quot;</dd>", "<i>"),
            ("<h2>Lights &amp; &lt;more&gt;</h2>", "<more>"),
            ("<p>5 &lt; 6</p>", "5 < 6"),
            ("alt=\"&quot;waste&quot;\"", "alt=\"\"waste"),
        ] {
            assert!(page.contains(escaped) && !page.contains(raw), "{escaped}");
        }
    }

    #[test]
    fn the_page_stands_alone() {
        let page = page("Report", &[], &sections()).expect("a page");
        assert!(page.matches("<svg ").count() == 2 && page.contains("data:image/png;base64,iVBORw0KGgo"));
        let (before, data) = page.split_once("base64,").expect("a picture");
        let (_, after) = data.split_once('"').expect("the picture's end");
        let bare = format!("{before}{after}").replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
        for reference in ["http", "//", "url(", "@import", "<script", "<link", "<iframe", "javascript:"] {
            assert!(!bare.contains(reference), "{reference}");
        }
        assert!(bare.matches(" src=\"").count() == 1 && bare.matches(" href=\"#").count() == 2);
        assert!(page.contains("prefers-color-scheme: dark") && page.contains("@media print"));
    }

    #[test]
    fn elements_are_closed() {
        let page = page("Report", &[("driver".into(), "llvmpipe".into())], &sections()).expect("a page");
        let names =
            ["html", "head", "body", "style", "dl", "dt", "nav", "section", "table", "thead", "tbody", "tr", "svg"];
        for name in names.iter().chain(&["th", "td", "figure", "p", "h1", "h2", "li", "text", "div", "caption"]) {
            let opened = page.matches(&format!("<{name} ")).count() + page.matches(&format!("<{name}>")).count();
            assert!(opened > 0 && opened == page.matches(&format!("</{name}>")).count(), "{name}");
        }
        assert!(page.contains("<td class=\"number\">123.4</td>") && page.contains("<td>forward</td>"));
    }

    #[test]
    fn a_picture_that_is_none_is_refused() {
        let section = Section { pictures: vec![("heat".into(), b"GIF89a".to_vec())], ..Section::default() };
        let error = page("Report", &[], &[section]).expect_err("refused").to_string();
        assert!(error.contains("heat"), "{error}");
    }
}
