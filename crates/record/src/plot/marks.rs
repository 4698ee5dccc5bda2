//! The look of a variant and its marks. The colours are those of Okabe and Ito (2008), which colour-blind readers can distinguish, and each
//! has a marker of its own, so that no figure depends on colour alone.

use super::canvas::{Area, DrawResult, TEXT_PX, text};
use super::data::Entry;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A position on the figure, px from its upper left corner.
pub type Pixel = (i32, i32);

/// Okabe and Ito's palette without its yellow, which is too faint for lines on white; each hue has a second shade for a dark page.
const PALETTE: [(RGBColor, RGBColor); 7] = [
    (RGBColor(0, 114, 178), RGBColor(90, 176, 230)),
    (RGBColor(230, 159, 0), RGBColor(240, 178, 60)),
    (RGBColor(0, 158, 115), RGBColor(47, 196, 154)),
    (RGBColor(0, 0, 0), RGBColor(217, 216, 212)),
    (RGBColor(213, 94, 0), RGBColor(255, 138, 76)),
    (RGBColor(86, 180, 233), RGBColor(143, 208, 245)),
    (RGBColor(204, 121, 167), RGBColor(227, 154, 198)),
];

/// Half the size of a marker, px.
const RADIUS: i32 = 7;

/// Width of a marker's outline, px.
const OUTLINE_PX: u32 = 2;

/// The shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    Circle,
    Square,
    Up,
    Diamond,
    Down,
    Bar,
}

impl Shape {
    /// The corners about the middle, px; empty for a circle.
    fn corners(self) -> Vec<Pixel> {
        let r = RADIUS;
        match self {
            Self::Circle => Vec::new(),
            Self::Square => vec![(-r, -r), (r, -r), (r, r), (-r, r)],
            Self::Up => vec![(-r, r - 1), (r, r - 1), (0, -r)],
            Self::Down => vec![(-r, 1 - r), (r, 1 - r), (0, r)],
            Self::Diamond => vec![(-r - 1, 0), (0, -r - 1), (r + 1, 0), (0, r + 1)],
            Self::Bar => vec![(-r - 2, -4), (r + 2, -4), (r + 2, 4), (-r - 2, 4)],
        }
    }
}

const SHAPES: [Shape; 6] = [Shape::Circle, Shape::Square, Shape::Up, Shape::Diamond, Shape::Down, Shape::Bar];

/// Colour and marker of a variant. A hollow marker means an unsafe variant, here and on the page, and nothing else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// Colour.
    pub colour: RGBColor,
    /// The same hue on a dark page.
    dark: RGBColor,
    shape: Shape,
    is_hollow: bool,
}

impl Look {
    /// The look of the `i`-th variant. Looks repeat after 42 variants, because 7 colours and 6 markers have no common divisor.
    pub const fn nth(i: usize) -> Self {
        let (colour, dark) = PALETTE[i % PALETTE.len()];
        Self { colour, dark, shape: SHAPES[i % SHAPES.len()], is_hollow: false }
    }

    /// The colours on a light page and on a dark page, as `#rrggbb`.
    pub fn css(self) -> [String; 2] {
        [self.colour, self.dark].map(|RGBColor(r, g, b)| format!("#{r:02x}{g:02x}{b:02x}"))
    }

    /// The marker's outline about the origin as an SVG path, px.
    pub fn path(self) -> String {
        let corners = self.shape.corners();
        if corners.is_empty() {
            let r = RADIUS;
            return format!("M-{r} 0a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0-{d} 0", d = 2 * r);
        }
        let steps = corners.iter().enumerate().map(|(i, (x, y))| format!("{}{x} {y}", if i == 0 { "M" } else { "L" }));
        steps.collect::<String>() + "z"
    }

    /// Whether the marker is hollow.
    pub const fn is_hollow(self) -> bool {
        self.is_hollow
    }

    /// The same look, hollow when the variant is not `safe` and may miss contacts.
    pub const fn of_promise(self, safe: bool) -> Self {
        Self { is_hollow: !safe, ..self }
    }

    /// Draws the marker.
    ///
    /// # Errors
    /// When the backend refuses.
    pub fn mark(self, area: &Area<'_>, (x, y): Pixel) -> DrawResult {
        let fill = if self.is_hollow { WHITE } else { self.colour };
        let corners: Vec<Pixel> = self.shape.corners().into_iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
        if corners.is_empty() {
            area.draw(&Circle::new((x, y), RADIUS, fill.filled()))?;
            return area.draw(&Circle::new((x, y), RADIUS, self.colour.stroke_width(OUTLINE_PX)));
        }
        area.draw(&Polygon::new(corners.clone(), fill.filled()))?;
        let around = corners.iter().chain(&corners[..1]).copied().collect::<Vec<_>>();
        area.draw(&PathElement::new(around, self.colour.stroke_width(OUTLINE_PX)))
    }

    /// Draws a vertical interval with caps.
    ///
    /// # Errors
    /// When the backend refuses.
    pub fn whisker(self, area: &Area<'_>, x: i32, from: i32, to: i32) -> DrawResult {
        let line = self.colour.stroke_width(2);
        area.draw(&PathElement::new(vec![(x, from), (x, to)], line))?;
        [from, to].into_iter().try_for_each(|y| area.draw(&PathElement::new(vec![(x - 4, y), (x + 4, y)], line)))
    }
}

/// Draws text with its middle or an end at a position.
///
/// # Errors
/// When the backend refuses.
pub fn label(area: &Area<'_>, words: &str, px: u32, at: Pixel, anchor: HPos) -> DrawResult {
    area.draw_text(words, &text(px).pos(Pos::new(anchor, VPos::Center)), at)
}

/// Width of a legend, px.
pub const LEGEND_PX: u32 = 360;

/// Distance from the middle of a text line up to the apparent middle of its lower-case letters, px.
pub const TEXT_LIFT_PX: i32 = 2;

/// Height of a legend's line, px.
const LEGEND_LINE_PX: i32 = 27;

/// Largest number of characters in a line of a legend.
const LEGEND_CHARS: usize = 34;

/// Breaks a label into lines that fit a legend.
pub fn wrap(label: &str, chars: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in label.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= chars => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Height that a legend of these variants needs, px.
pub fn legend_height(entries: &[Entry]) -> u32 {
    entries.iter().map(|e| wrap(&e.label, LEGEND_CHARS).len() as u32 * LEGEND_LINE_PX as u32 + 8).sum::<u32>() + 24
}

/// Draws marker and label of each variant, one below the other.
///
/// # Errors
/// When the backend refuses.
pub fn legend(area: &Area<'_>, entries: &[Entry], (x, mut y): Pixel) -> DrawResult {
    for entry in entries {
        entry.look.mark(area, (x + RADIUS, y - TEXT_LIFT_PX))?;
        for line in wrap(&entry.label, LEGEND_CHARS) {
            label(area, &line, TEXT_PX, (x + 28, y), HPos::Left)?;
            y += LEGEND_LINE_PX;
        }
        y += 8;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_repeat_late() {
        for i in 0..42 {
            assert!((0..i).all(|j| Look::nth(i) != Look::nth(j)), "{i}");
        }
        assert_eq!(Look::nth(42), Look::nth(0));
        assert_ne!(Look::nth(0).of_promise(false), Look::nth(0));
    }

    #[test]
    fn every_shape_has_a_path_of_its_own() {
        let paths: Vec<String> = (0..SHAPES.len()).map(|i| Look::nth(i).path()).collect();
        assert!(paths.iter().enumerate().all(|(i, path)| !paths[..i].contains(path)), "{paths:?}");
        assert_eq!(paths[1], "M-7 -7L7 -7L7 7L-7 7z");
        assert_eq!(Look::nth(0).css(), ["#0072b2", "#5ab0e6"]);
    }

    #[test]
    fn labels_are_broken_at_spaces() {
        assert_eq!(wrap("one two three", 7), ["one two", "three"]);
        assert_eq!(wrap("unbreakable", 3), ["unbreakable"]);
    }
}
