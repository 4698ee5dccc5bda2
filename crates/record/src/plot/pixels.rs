//! A bitmap backend that places letters as the font specifies. The drawing library's own text ignores the space to the left of each glyph's
//! outline, so that words run together. Everything but text is drawn by the library.

use ab_glyph::{Font, FontRef, ScaleFont, point};
use plotters::prelude::{BitMapBackend, DrawingBackend};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind};

/// The bitmap with the font of its texts.
pub struct Pixels<'a> {
    bitmap: BitMapBackend<'a>,
    font: FontRef<'static>,
}

impl<'a> Pixels<'a> {
    /// A backend that draws into `bitmap` with a font, given as the bytes of its file; `None` when the bytes are no font.
    pub fn new(bitmap: BitMapBackend<'a>, font: &'static [u8]) -> Option<Self> {
        Some(Self { bitmap, font: FontRef::try_from_slice(font).ok()? })
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

type Drawn<'a> = Result<(), DrawingErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>>;

impl<'a> DrawingBackend for Pixels<'a> {
    type ErrorType = <BitMapBackend<'a> as DrawingBackend>::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        self.bitmap.get_size()
    }

    fn ensure_prepared(&mut self) -> Drawn<'a> {
        self.bitmap.ensure_prepared()
    }

    fn present(&mut self) -> Drawn<'a> {
        self.bitmap.present()
    }

    fn draw_pixel(&mut self, at: BackendCoord, colour: BackendColor) -> Drawn<'a> {
        self.bitmap.draw_pixel(at, colour)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn<'a> {
        self.bitmap.draw_line(from, to, style)
    }

    fn draw_rect<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S, fill: bool) -> Drawn<'a> {
        self.bitmap.draw_rect(from, to, style, fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Drawn<'a> {
        self.bitmap.draw_path(path, style)
    }

    fn draw_circle<S: BackendStyle>(&mut self, centre: BackendCoord, radius: u32, style: &S, fill: bool) -> Drawn<'a> {
        self.bitmap.draw_circle(centre, radius, style, fill)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Drawn<'a> {
        self.bitmap.fill_polygon(corners, style)
    }

    fn draw_text<T: BackendTextStyle>(&mut self, text: &str, style: &T, at: BackendCoord) -> Drawn<'a> {
        let colour = style.color();
        if colour.alpha == 0.0 {
            return Ok(());
        }
        let layout = style.layout_box(text).map_err(|error| DrawingErrorKind::FontError(Box::new(error)))?;
        let size = style.size() as f32;
        let (width, height) = (width_of(&self.font, size, text).round() as i32, layout.1.1 - layout.0.1);
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
            let scaled = self.font.as_scaled(size);
            let id = scaled.glyph_id(c);
            pen += previous.map_or(0.0, |previous| scaled.kern(previous, id));
            previous = Some(id);
            // The line's middle is where the library has it: half the size below its top.
            let glyph = id.with_scale_and_position(size, point(pen, size / 2.0));
            pen += scaled.h_advance(id);
            let Some(outline) = self.font.outline_glyph(glyph) else { continue };
            let corner = outline.px_bounds().min;
            let mut covered = Vec::new();
            outline.draw(|x, y, share| covered.push((x, y, share)));
            for (x, y, share) in covered {
                let (x, y) = (x as i32 + corner.x as i32 + dx, y as i32 + corner.y as i32 + dy);
                let (x, y) = turn.transform(x, y);
                let shade = BackendColor { alpha: colour.alpha * f64::from(share.min(1.0)), ..colour };
                self.bitmap.draw_pixel((at.0 + x, at.1 + y), shade)?;
            }
        }
        Ok(())
    }
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
            let mut pixels = Pixels::new(bitmap, epaint_default_fonts::UBUNTU_LIGHT).unwrap();
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
