//! A page of HTML that needs no other file.

use crate::output::figure::{Curve, Figure, Panel, Scale};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::fmt::Write;
use std::io::Write as _;

const STYLE: &str = include_str!("style.css");
const VIEWER: &str = include_str!("viewer.js");
/// Has browsers load a page again after so many seconds.
const RELOAD: &str = "<meta http-equiv=\"refresh\" content=\"60\">\n";
/// Columns of a table that is too wide for most screens.
const WIDE: usize = 9;
const LIBRARY: &str = include_str!("vendor/three.min.js");

/// A page, section by section.
pub struct Page {
    title: String,
    lead: String,
    sections: Vec<(String, String, String)>,
    has_viewer: bool,
    /// What is said of a run that has not ended.
    going_on: Option<String>,
}

impl Page {
    /// An empty page; `lead` is a sentence below the title.
    pub fn new(title: &str, lead: &str) -> Self {
        Self {
            title: title.into(),
            lead: lead.into(),
            sections: Vec::new(),
            has_viewer: false,
            going_on: None,
        }
    }

    /// Makes it the page of a run that has not ended, as a sentence says: browsers reload it each minute.
    pub fn of_unfinished_run(&mut self, sentence: &str) {
        self.going_on = Some(sentence.into());
    }

    /// Adds a section with this HTML; `id` is where links lead.
    pub fn section(&mut self, id: &str, title: &str, html: &str) {
        self.has_viewer |= html.contains("class=\"viewer\"");
        self.sections.push((id.into(), title.into(), html.into()));
    }

    /// The whole page.
    pub fn to_html(&self) -> String {
        let title = escape(&self.title);
        let mut html = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             {}<title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<p class=\"lead\">{}</p>\n{}<nav>",
            self.going_on.as_ref().map_or("", |_| RELOAD),
            escape(&self.lead),
            warnings(self.going_on.as_slice()),
        );
        for (id, title, _) in &self.sections {
            let _ = write!(html, "<a href=\"#{id}\">{}</a>", escape(title));
        }
        html.push_str("</nav>\n");
        for (id, title, body) in &self.sections {
            let _ = writeln!(
                html,
                "<section id=\"{id}\">\n<h2>{}</h2>\n{body}</section>",
                escape(title)
            );
        }
        let _ = writeln!(
            html,
            "<footer><p>Made by fsi-driver {}.{}</p></footer>",
            env!("CARGO_PKG_VERSION"),
            if self.has_viewer {
                " Three-dimensional views by three.js 0.187.0 (MIT License, © three.js authors), which is part of this page."
            } else {
                ""
            }
        );
        if self.has_viewer {
            let _ = writeln!(
                html,
                "<script type=\"application/gzip\" id=\"library\">{}</script>\n<script>\n{VIEWER}</script>",
                library()
            );
        }
        html.push_str("</body>\n</html>\n");
        html
    }
}

/// The library of the viewer, compressed: a third of its size, base 64 included.
fn library() -> String {
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    let packed = packed
        .write_all(LIBRARY.as_bytes())
        .and_then(|()| packed.finish());
    STANDARD.encode(packed.expect("memory can be written"))
}

/// Text within HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// Figures side by side where there is room: two in a row, or three where that leaves no gap.
pub fn gallery(figures: &[String]) -> String {
    let count = figures.iter().filter(|f| f.starts_with("<figure")).count();
    let class = match count % 2 {
        1 if count.is_multiple_of(3) => "figures three",
        1 if count > 1 => "figures odd",
        _ => "figures",
    };
    format!("<div class=\"{class}\">\n{}</div>\n", figures.concat())
}

/// Sentences that a reader must not miss.
pub fn warnings(sentences: &[String]) -> String {
    let lines = sentences
        .iter()
        .map(|text| format!("<p class=\"warning\">{}</p>\n", escape(text)));
    lines.collect()
}

/// A number with that many significant digits, so that what is small does not look like nothing.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let places = digits as i32 - 1 - value.abs().log10().floor() as i32;
    let text = match places {
        i32::MIN..0 => format!("{value:.0}"),
        0..9 => format!("{value:.*}", places as usize),
        _ => format!("{value:.*e}", digits - 1),
    };
    text.replace('-', "\u{2212}")
}

/// A name as a part of a file's name.
pub fn file_name(name: &str) -> String {
    let kept = |c: char| c.is_alphanumeric() || "-._".contains(c);
    name.chars()
        .map(|c| if kept(c) { c } else { '-' })
        .collect()
}

/// A link to numbers that are part of the page, to download as `name`.csv.
pub fn download(name: &str, csv: &str) -> String {
    let data = STANDARD.encode(csv);
    format!(
        " <a class=\"download\" download=\"{name}.csv\" href=\"data:text/csv;base64,{data}\">{name}.csv</a>"
    )
}

/// A figure with its caption, and its numbers to download as `name`.csv.
pub fn figure(svg: &str, caption: &str, numbers: Option<(&str, String)>) -> String {
    let download = numbers.map_or(String::new(), |(name, csv)| download(name, &csv));
    format!(
        "<figure>\n{svg}<figcaption>{}{download}</figcaption>\n</figure>\n",
        escape(caption)
    )
}

/// A pair of linear axes with curves, as a figure with its numbers.
pub fn chart(name: &str, caption: &str, panel: Panel) -> String {
    let csv = numbers(&panel);
    let drawn = Figure {
        panels: vec![panel],
        columns: 1,
    };
    figure(&drawn.to_svg(), caption, Some((name, csv)))
}

/// A panel with a title and linear axes.
pub fn panel(title: &str, x_label: &str, y_label: &str, curves: Vec<Curve>) -> Panel {
    Panel {
        title: title.into(),
        x_label: x_label.into(),
        y_label: y_label.into(),
        scales: [Scale::Linear; 2],
        curves,
    }
}

/// A mere line.
pub fn line(name: &str, colour: usize, points: Vec<(f64, f64)>) -> Curve {
    Curve {
        name: name.into(),
        points,
        colour,
        marker: None,
        open: false,
    }
}

/// The curves of a panel as a table: side by side if they share their x, otherwise one after the other.
fn numbers(panel: &Panel) -> String {
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let Some(first) = panel.curves.first() else {
        return String::new();
    };
    let xs = |curve: &Curve| curve.points.iter().map(|p| p.0).collect::<Vec<_>>();
    let shared = panel.curves.iter().all(|curve| xs(curve) == xs(first));
    let mut csv = String::new();
    if shared {
        csv += &quoted(&panel.x_label);
        for curve in &panel.curves {
            let name = if curve.name.is_empty() {
                &panel.y_label
            } else {
                &curve.name
            };
            let _ = write!(csv, ",{}", quoted(name));
        }
        for (i, (x, _)) in first.points.iter().enumerate() {
            let _ = write!(csv, "\n{x:.7}");
            for curve in &panel.curves {
                let _ = write!(csv, ",{:.6e}", curve.points[i].1);
            }
        }
    } else {
        let _ = write!(
            csv,
            "curve,{},{}",
            quoted(&panel.x_label),
            quoted(&panel.y_label)
        );
        for curve in &panel.curves {
            for (x, y) in &curve.points {
                let _ = write!(csv, "\n{},{x:.7},{y:.6e}", quoted(&curve.name));
            }
        }
    }
    csv.push('\n');
    csv
}

/// A table: its heads and rows of cells; all are HTML already.
pub fn table(heads: &[&str], rows: &[Vec<String>]) -> String {
    let class = match heads.len() {
        ..WIDE => "table",
        _ => "table wide",
    };
    let mut html = format!("<div class=\"{class}\"><table>\n<thead><tr>");
    for head in heads {
        let _ = write!(html, "<th>{head}</th>");
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in rows {
        html.push_str("<tr>");
        for (head, cell) in heads.iter().zip(row) {
            // Sentences, which are marked as such, wrap; numbers do not.
            let class = if cell.contains("<span") {
                " class=\"text\""
            } else {
                ""
            };
            // On narrow screens each cell stands on a line of its own, after its head.
            let head = head.replace("<br>", ", ");
            let _ = write!(
                html,
                "<td{class} data-head=\"{head}\"><div>{cell}</div></td>"
            );
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody>\n</table></div>\n");
    html
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_numbers_keep_their_digits() {
        let shown =
            [0.0, 0.0342, 1.0, 99.96, 123_456.0, -2.5e-9, 4.2e-6].map(|x| significant(x, 3));
        let expected = [
            "0",
            "0.0342",
            "1.00",
            "100.0",
            "123456",
            "\u{2212}2.50e\u{2212}9",
            "0.00000420",
        ];
        assert_eq!(shown, expected);
        assert_eq!(file_name("A leg, 3 mm/left"), "A-leg--3-mm-left");
    }

    #[test]
    fn a_gallery_leaves_no_half_row() {
        let class = |count: usize| {
            let html = gallery(&vec!["<figure></figure>".to_owned(); count]);
            html.split('"').nth(1).unwrap().to_owned()
        };
        assert_eq!(
            [1, 2, 3].map(class),
            ["figures", "figures", "figures three"]
        );
        assert_eq!(
            [4, 5, 6, 9].map(class),
            ["figures", "figures odd", "figures", "figures three"]
        );
    }
}
