//! Shares as bars with intervals, a pair of bars for each name.

use super::FAMILY;
use std::fmt::Write;

/// Width of the whole, and of the names at its left and the numbers at its right.
const WIDTH: f64 = 440.0;
const NAMES: f64 = 120.0;
const NUMBERS: f64 = 62.0;
/// Height of a row, of what is above them and of what is below.
const ROW: f64 = 34.0;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 26.0;
/// Height of a bar.
const BAR: f64 = 11.0;
/// Colours of the bars, as those of curves.
const COLOURS: [&str; 2] = ["#0072b2", "#e69f00"];
/// Longest name that fits.
const LONGEST: usize = 17;

/// Two shares with their intervals.
pub struct Bars {
    /// Stands at the left.
    pub name: String,
    /// Each a share from 0 to 1 with its interval.
    pub shares: [(f64, [f64; 2]); 2],
}

/// The bars below a title, and what the two of each pair are called.
pub fn bars(title: &str, kinds: [&str; 2], rows: &[Bars]) -> String {
    let height = TOP + ROW * rows.len() as f64 + BOTTOM;
    let bottom = height - BOTTOM;
    let at = |share: f64| NAMES + (WIDTH - NAMES - NUMBERS) * share.clamp(0.0, 1.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\" \
         font-family=\"{FAMILY}\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    let text = |svg: &mut String, x: f64, y: f64, anchor: &str, text: &str| {
        let text = text.replace('&', "&amp;").replace('<', "&lt;");
        let _ = writeln!(
            svg,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>"
        );
    };
    text(&mut svg, WIDTH / 2.0, 16.0, "middle", title);
    for (i, kind) in kinds.iter().enumerate() {
        let x = NAMES + 130.0 * i as f64;
        let colour = COLOURS[i];
        let _ = writeln!(
            svg,
            "<rect x=\"{x}\" y=\"27\" width=\"12\" height=\"{BAR}\" fill=\"{colour}\"/>"
        );
        text(&mut svg, x + 17.0, 37.0, "start", kind);
    }
    for tenth in [0, 2, 4, 6, 8, 10] {
        let x = at(f64::from(tenth) / 10.0);
        let _ = writeln!(
            svg,
            "<line x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{TOP}\" y2=\"{bottom}\" stroke=\"#ddd\"/>"
        );
        let label = format!("{:.1}", f64::from(tenth) / 10.0);
        text(&mut svg, x, bottom + 16.0, "middle", &label);
    }
    for (i, row) in rows.iter().enumerate() {
        let top = TOP + ROW * i as f64;
        let name: String = match row.name.chars().count() {
            ..=LONGEST => row.name.clone(),
            _ => row.name.chars().take(LONGEST - 1).chain(['…']).collect(),
        };
        text(&mut svg, NAMES - 8.0, top + ROW / 2.0 + 4.0, "end", &name);
        for (j, (share, [low, high])) in row.shares.iter().enumerate() {
            let y = top + ROW / 2.0 + if j == 0 { -BAR - 1.0 } else { 1.0 };
            let middle = y + BAR / 2.0;
            let colour = COLOURS[j];
            let [left, right, low, high] = [0.0, *share, *low, *high].map(at);
            let _ = writeln!(
                svg,
                "<rect x=\"{left:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{BAR}\" fill=\"{colour}\"/>\n\
                 <path d=\"M{low:.1} {middle:.1}H{high:.1}M{low:.1} {:.1}v6M{high:.1} {:.1}v6\" stroke=\"black\"/>",
                right - left,
                middle - 3.0,
                middle - 3.0,
            );
            text(
                &mut svg,
                WIDTH - 4.0,
                y + 10.0,
                "end",
                &format!("{share:.3}"),
            );
        }
    }
    svg.push_str("</svg>\n");
    svg
}
