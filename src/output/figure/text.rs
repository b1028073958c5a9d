//! Labels.

use std::fmt::Write;

/// Letters that a label shows.
pub(super) fn letters(label: &str) -> usize {
    let shown = label.replace("_{", "").replace("^{", "").replace('}', "");
    shown.chars().count()
}

/// Text with `_{…}` lowered and `^{…}` raised.
pub(super) fn text(svg: &mut String, x: f64, y: f64, anchor: &str, size: f64, label: &str) {
    let _ = write!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\">"
    );
    let escaped = label.replace('&', "&amp;").replace('<', "&lt;");
    let mut rest = escaped.as_str();
    // How far the line must move to be back at its height.
    let mut back = 0.0;
    loop {
        let marked = rest.find(['_', '^']).and_then(|at| {
            let (inner, after) = rest[at + 1..].strip_prefix('{')?.split_once('}')?;
            let shift = if &rest[at..=at] == "_" { 3.0 } else { -4.0 };
            Some((&rest[..at], shift, inner, after))
        });
        let (plain, small) = match marked {
            Some((plain, shift, inner, _)) => (plain, Some((shift, inner))),
            None => (rest, None),
        };
        if !plain.is_empty() {
            let _ = write!(svg, "<tspan dy=\"{back}\">{plain}</tspan>");
            back = 0.0;
        }
        if let Some((shift, inner)) = small {
            let (dy, size) = (back + shift, 0.75 * size);
            let _ = write!(
                svg,
                "<tspan dy=\"{dy}\" font-size=\"{size}\">{inner}</tspan>"
            );
            back = -shift;
        }
        match marked {
            Some((.., after)) => rest = after,
            None => break,
        }
    }
    svg.push_str("</text>\n");
}

/// The label of an axis or a colour bar next to it, centred at (x, y) and read from below.
pub(super) fn upward(svg: &mut String, x: f64, y: f64, label: &str) {
    let _ = write!(
        svg,
        "<g transform=\"translate({x:.1} {y:.1}) rotate(-90)\">"
    );
    text(svg, 0.0, 0.0, "middle", 12.0, label);
    svg.push_str("</g>\n");
}
