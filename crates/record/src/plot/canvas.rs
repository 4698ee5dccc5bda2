//! Writes one drawing as two files: SVG as text and PNG as pixels.
//!
//! The PNG needs glyphs without fonts of the system. They come from Ubuntu Light (Ubuntu Font Licence 1.0, which allows embedding and use
//! in documents), as shipped by the crate `epaint_default_fonts`. The SVG names the generic family `sans-serif`, and the viewer chooses the
//! font.

use super::backend::Backend;
use ab_glyph::FontRef;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::Path;
use std::sync::Once;

/// Error message when the embedded font cannot be read.
const NO_FONT: &str = "the embedded font cannot be read";

/// The font family of all text.
pub const FAMILY: &str = "sans-serif";

/// Text sizes, px.
pub const TITLE_PX: u32 = 30;
/// Titles of panels.
pub const PANEL_PX: u32 = 24;
/// Axis labels, legends.
pub const TEXT_PX: u32 = 21;

/// Height of the strip above a drawing that holds the figure's title, px.
const TITLE_STRIP_PX: u32 = 56;

/// The surface that figures are drawn on.
pub type Area<'a> = DrawingArea<Backend<'a>, Shift>;

/// Result of drawing.
pub type DrawResult = Result<(), DrawingAreaErrorKind<io::Error>>;

/// Something that can be drawn.
pub trait Drawing {
    /// Width and height, px.
    fn size(&self) -> (u32, u32);

    /// Draws on an area, which has that size and is white.
    ///
    /// # Errors
    /// When the backend reports an error.
    fn draw(&self, area: &Area<'_>) -> DrawResult;
}

/// A drawing with a title above it.
#[derive(Clone, Copy)]
pub struct Titled<'a> {
    /// The title.
    pub title: &'a str,
    /// The drawing.
    pub drawing: &'a dyn Drawing,
}

impl Drawing for Titled<'_> {
    fn size(&self) -> (u32, u32) {
        let (width, height) = self.drawing.size();
        (width, height + TITLE_STRIP_PX)
    }

    fn draw(&self, area: &Area<'_>) -> DrawResult {
        let (strip, rest) = area.split_vertically(TITLE_STRIP_PX);
        strip.draw_text(self.title, &text(TITLE_PX), (16, 16))?;
        self.drawing.draw(&rest)
    }
}

/// Black text of a size.
pub fn text(px: u32) -> TextStyle<'static> {
    (FAMILY, px).into_font().color(&BLACK)
}

pub(super) fn register() -> Result<(), String> {
    static ONCE: Once = Once::new();
    let mut result = Ok(());
    ONCE.call_once(|| {
        result = register_font(FAMILY, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)
            .map_err(|_| NO_FONT.to_owned());
    });
    result
}

fn paint(drawing: &dyn Drawing, backend: Backend<'_>) -> Result<(), String> {
    let area = backend.into_drawing_area();
    area.fill(&WHITE)
        .and_then(|()| drawing.draw(&area))
        .and_then(|()| area.present())
        .map_err(|error| error.to_string())
}

/// Renders the drawing as SVG text.
///
/// # Errors
/// The error of the drawing library.
pub fn svg(drawing: &dyn Drawing) -> Result<String, String> {
    register()?;
    let mut text = String::new();
    paint(drawing, Backend::Svg(SVGBackend::with_string(&mut text, drawing.size())))?;
    Ok(text)
}

/// Writes the drawing as PNG, under a temporary name first.
///
/// # Errors
/// The error of the drawing library or the file system.
pub fn write_png(drawing: &dyn Drawing, path: &Path) -> Result<(), String> {
    let (width, height) = drawing.size();
    write_pixels(&pixels(drawing)?, (width as usize, height as usize), path)
}

/// Writes pixels, three bytes each, row by row, as PNG, under a temporary name first.
///
/// # Errors
/// The error of the file system, or a wrong number of bytes for the size.
pub fn write_pixels(rgb: &[u8], (width, height): (usize, usize), path: &Path) -> Result<(), String> {
    if rgb.len() != 3 * width * height {
        return Err(format!("{} bytes are no picture of {width} x {height} pixels", rgb.len()));
    }
    let temporary = path.with_extension("partial.png");
    let write = || -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(BufWriter::new(File::create(&temporary)?), width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(rgb)?;
        writer.finish()?;
        Ok(fs::rename(&temporary, path)?)
    };
    write().map_err(|error| format!("{}: {error}", path.display()))
}

/// Renders the drawing as pixels, three bytes each, row by row.
///
/// # Errors
/// The error of the drawing library.
pub fn pixels(drawing: &dyn Drawing) -> Result<Vec<u8>, String> {
    register()?;
    let (width, height) = drawing.size();
    let mut buffer = vec![0; (width * height * 3) as usize];
    let bitmap = BitMapBackend::with_buffer(&mut buffer, (width, height));
    let font = FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).map_err(|_| NO_FONT)?;
    paint(drawing, Backend::Pixels(bitmap, Box::new(font)))?;
    Ok(buffer)
}
