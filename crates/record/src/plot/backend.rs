//! What figures are drawn on: SVG text or pixels. One type for both, so that every figure is compiled once. The drawing library draws
//! everything but the letters of a bitmap: it ignores the space to the left of each glyph's outline, so that words run together. They are
//! placed here, as the font specifies.

use ab_glyph::{Font, FontRef, ScaleFont, point};
use plotters::prelude::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind};
use std::{error, io};

/// SVG text or pixels.
pub enum Backend<'a> {
    /// SVG text.
    Svg(SVGBackend<'a>),
    /// Pixels, with the font of the texts.
    Pixels(BitMapBackend<'a>, Box<FontRef<'static>>),
}

type Drawn = Result<(), DrawingErrorKind<io::Error>>;

/// An error of the bitmap as one of SVG, with the same message.
fn of_pixels<E: error::Error + Send + Sync + 'static>(error: DrawingErrorKind<E>) -> DrawingErrorKind<io::Error> {
    match error {
        DrawingErrorKind::DrawingError(error) => DrawingErrorKind::DrawingError(io::Error::other(error)),
        DrawingErrorKind::FontError(error) => DrawingErrorKind::FontError(error),
    }
}

/// Hands a call on to what is drawn on.
macro_rules! forward {
    ($backend:ident.$call:ident($($value:expr),*)) => {
        match $backend {
            Backend::Svg(svg) => svg.$call($($value),*),
            Backend::Pixels(bitmap, _) => bitmap.$call($($value),*).map_err(of_pixels),
        }
    };
}

impl DrawingBackend for Backend<'_> {
    type ErrorType = io::Error;

    fn get_size(&self) -> (u32, u32) {
        match self {
            Self::Svg(svg) => svg.get_size(),
            Self::Pixels(bitmap, _) => bitmap.get_size(),
        }
    }

    fn ensure_prepared(&mut self) -> Drawn {
        forward!(self.ensure_prepared())
    }

    fn present(&mut self) -> Drawn {
        forward!(self.present())
    }

    fn draw_pixel(&mut self, at: BackendCoord, colour: BackendColor) -> Drawn {
        forward!(self.draw_pixel(at, colour))
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        forward!(self.draw_line(from, to, style))
    }

    fn draw_rect<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S, fill: bool) -> Drawn {
        forward!(self.draw_rect(from, to, style, fill))
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Drawn {
        forward!(self.draw_path(path, style))
    }

    fn draw_circle<S: BackendStyle>(&mut self, centre: BackendCoord, radius: u32, style: &S, fill: bool) -> Drawn {
        forward!(self.draw_circle(centre, radius, style, fill))
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, corners: I, style: &S) -> Drawn {
        forward!(self.fill_polygon(corners, style))
    }

    fn draw_text<T: BackendTextStyle>(&mut self, text: &str, style: &T, at: BackendCoord) -> Drawn {
        match self {
            Self::Svg(svg) => svg.draw_text(text, style, at),
            Self::Pixels(bitmap, font) => draw_letters(bitmap, font, text, style, at),
        }
    }
}

/// Width of a text, px: the sum of the advances with kerning.
fn width_of(font: &FontRef<'_>, size: f32, text: &str) -> f32 {
    let font = font.as_scaled(size);
    let mut previous = None;
    let mut width = 0.0;
    for id in text.chars().map(|c| font.glyph_id(c)) {
        width += previous.map_or(0.0, |previous| font.kern(previous, id)) + font.h_advance(id);
        previous = Some(id);
    }
    width
}

fn draw_letters<T: BackendTextStyle>(
    bitmap: &mut BitMapBackend<'_>,
    font: &FontRef<'_>,
    text: &str,
    style: &T,
    at: BackendCoord,
) -> Drawn {
    let colour = style.color();
    if colour.alpha == 0.0 {
        return Ok(());
    }
    let layout = style.layout_box(text).map_err(|error| DrawingErrorKind::FontError(Box::new(error)))?;
    let size = style.size() as f32;
    let (width, height) = (width_of(font, size, text).round() as i32, layout.1.1 - layout.0.1);
    let dx = match style.anchor().h_pos {
        HPos::Left => 0,
        HPos::Right => -width,
        HPos::Center => -width / 2,
    };
    let dy = match style.anchor().v_pos {
        VPos::Top => 0,
        VPos::Center => -height / 2,
        VPos::Bottom => -height,
    };
    let turn = style.transform();
    let (mut pen, mut previous) = (0.0, None);
    for c in text.chars() {
        let scaled = font.as_scaled(size);
        let id = scaled.glyph_id(c);
        pen += previous.map_or(0.0, |previous| scaled.kern(previous, id));
        previous = Some(id);
        // The line's middle is where the library has it: half the size below its top.
        let glyph = id.with_scale_and_position(size, point(pen, size / 2.0));
        pen += scaled.h_advance(id);
        let Some(outline) = font.outline_glyph(glyph) else { continue };
        let corner = outline.px_bounds().min;
        let mut covered = Vec::new();
        outline.draw(|x, y, share| covered.push((x, y, share)));
        for (x, y, share) in covered {
            let (x, y) = (x as i32 + corner.x as i32 + dx, y as i32 + corner.y as i32 + dy);
            let (x, y) = turn.transform(x, y);
            let shade = BackendColor { alpha: colour.alpha * f64::from(share.min(1.0)), ..colour };
            bitmap.draw_pixel((at.0 + x, at.1 + y), shade).map_err(of_pixels)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The gap between two words is as wide as the font's space, and no letter starts to the left of its pen position.
    #[test]
    fn words_stand_apart() {
        let (width, height) = (240_u32, 40_u32);
        let mut buffer = vec![0; (3 * width * height) as usize];
        let size = 30.0;
        {
            let bitmap = BitMapBackend::with_buffer(&mut buffer, (width, height));
            let font = FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).unwrap();
            let mut pixels = Backend::Pixels(bitmap, Box::new(font));
            super::super::canvas::register().unwrap();
            let style = super::super::canvas::text(30).color(&plotters::style::WHITE);
            pixels.draw_text("l l", &style, (4, 4)).unwrap();
        }
        let lit = |x: u32| (0..height).any(|y| buffer[(3 * (y * width + x)) as usize] > 64);
        let columns: Vec<u32> = (0..width).filter(|x| lit(*x)).collect();
        let gap = columns.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap();
        let font = FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).unwrap();
        let space = font.as_scaled(size).h_advance(font.glyph_id(' '));
        assert!(f64::from(gap) > f64::from(space), "{gap} columns for a space of {space}");
    }
}
