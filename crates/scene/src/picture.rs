//! A picture of a scene: orthographic and shaded, with outlines of parts and edges.
//!
//! Triangles are drawn into a depth buffer of `SAMPLES`² samples per pixel; each sample stores the colour of its part and the normal of its
//! face. A sample is darkened when its neighbour lies on another part, at another depth, or on a face with another direction, as in the
//! non-photorealistic outlines of Saito and Takahashi (1990). A pixel is the mean of its samples. The same scene gives the same bytes.

use crate::geometry::{Isometry, Point, Triangle, Vector};
use crate::machine::Poses;
use crate::scene::{Role, Scene};
use nalgebra::{Matrix3, Rotation3};
use thiserror::Error;

/// Number of samples along each side of a pixel.
const SAMPLES: usize = 3;
/// Width of the empty border, as a fraction of the picture's width.
const MARGIN: f64 = 0.03;
/// Permitted range of height over width.
const SHAPE: (f64, f64) = (0.5, 1.25);
/// Widest picture, pixels. Its samples take 32 bytes each, so at most 1.5 GB in total.
const WIDEST: usize = 2048;
/// Direction towards the light in the picture's frame: right, up, towards the eye.
const LIGHT: [f64; 3] = [-0.42, 0.72, 0.55];
/// Cosine of the angle between faces above which an edge is drawn: 25 degrees, more than between facets of any curve.
const EDGE_COSINE: f64 = 0.906;
/// Smallest step in depth at which an outline is drawn within a part, as a fraction of the picture's width.
const STEP: f64 = 0.008;
/// Brightness of an outline, as a fraction of the brightness without it.
const INK: f64 = 0.45;

/// The axis that points up in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// As on lathes.
    Y,
    /// As on mills.
    #[default]
    Z,
}

/// The view of a scene: direction, tool and parts shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// The axis that is up.
    pub up: Up,
    /// Rotation of the eye about the up axis, radians; at 0 it looks along +y (if z is up) or -z (if y is up).
    pub azimuth: f64,
    /// Elevation of the eye above the horizon, radians.
    pub elevation: f64,
    /// The tool in the spindle; parts of other tools are not shown.
    pub tool: u32,
    /// Indices of the parts that the picture is framed on; when empty, all parts.
    pub focus: Vec<usize>,
    /// Width, pixels.
    pub width: usize,
}

/// Why a picture cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PictureError {
    /// The width is out of range.
    #[error("a picture is 16 to {WIDEST} pixels wide, not {0}")]
    Width(usize),
    /// An angle is not finite.
    #[error("the direction of view is not finite")]
    Direction,
}

/// Pixels with three bytes each (red, green, blue), row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels of a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `3 * width * height` bytes.
    pub rgb: Vec<u8>,
}

/// Makes a picture of a scene with its links at `poses`.
///
/// # Errors
/// When the view is invalid.
pub fn take(scene: &Scene, poses: &Poses, view: &View) -> Result<Image, PictureError> {
    if !(16..=WIDEST).contains(&view.width) {
        return Err(PictureError::Width(view.width));
    }
    if !(view.azimuth.is_finite() && view.elevation.is_finite()) {
        return Err(PictureError::Direction);
    }
    let eye = Isometry::from_parts(nalgebra::Translation3::identity(), eye_from_world(view).into());
    let placed = |part: usize| eye * scene.world_from_part(part, poses);
    let there = |part: &usize| scene.parts[*part].tool.is_none_or(|own| own == view.tool);
    let shown = |part: &usize| there(part) && (view.focus.is_empty() || view.focus.contains(part));
    let frame = Frame::around(
        (0..scene.parts.len()).filter(shown).flat_map(|part| {
            let eye_from_part = placed(part);
            scene.parts[part].mesh.vertices().iter().map(move |vertex| eye_from_part * vertex)
        }),
        view.width,
    );
    let mut canvas = Canvas::new(&frame);
    for part in (0..scene.parts.len()).filter(there) {
        let eye_from_part = placed(part);
        for triangle in scene.parts[part].mesh.triangles() {
            canvas.add(part, &triangle.map(|corner| eye_from_part * corner), &frame);
        }
    }
    let colours: Vec<Vector> = (0..scene.parts.len()).map(|part| colour(scene, part)).collect();
    Ok(canvas.develop(&colours, STEP * (SAMPLES * view.width) as f64))
}

/// The rotation from the world frame to the picture's frame: x right, y up, z towards the eye.
fn eye_from_world(view: &View) -> Rotation3<f64> {
    let axes = match view.up {
        Up::Z => Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0),
        Up::Y => Matrix3::identity(),
    };
    let turned = Rotation3::from_axis_angle(&Vector::y_axis(), -view.azimuth);
    Rotation3::from_axis_angle(&Vector::x_axis(), view.elevation) * turned * Rotation3::from_matrix_unchecked(axes)
}

/// The colour of a part, 0 to 1, by its role; machine parts that no pair names are lighter.
fn colour(scene: &Scene, part: usize) -> Vector {
    let examined = scene.names_pairs && scene.pairs.iter().any(|pair| pair.a == part || pair.b == part);
    match scene.parts[part].role {
        Role::Cutter | Role::Shank => Vector::new(0.90, 0.33, 0.16),
        Role::Holder => Vector::new(0.62, 0.42, 0.66),
        Role::Workpiece => Vector::new(0.27, 0.53, 0.78),
        Role::Fixture => Vector::new(0.42, 0.64, 0.42),
        Role::Machine if examined => Vector::new(0.93, 0.68, 0.25),
        // Neighbouring grey parts in slightly different greys.
        Role::Machine => Vector::new(0.78, 0.80, 0.82) - Vector::repeat(0.06 * (part % 3) as f64),
    }
}

/// The rectangle of the picture's plane that is shown, and its scale.
struct Frame {
    /// Coordinates of its upper left corner, mm.
    left: f64,
    top: f64,
    /// Samples per mm.
    scale: f64,
    /// Pixels.
    width: usize,
    height: usize,
}

impl Frame {
    fn around(points: impl Iterator<Item = Point>, width: usize) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        if low[0] > high[0] {
            (low, high) = ([0.0; 2], [0.0; 2]);
        }
        let [wide, high_mm] = [0, 1].map(|axis| (high[axis] - low[axis]).max(1e-3));
        let shape = (high_mm / wide).clamp(SHAPE.0, SHAPE.1);
        let height = (width as f64 * shape).round() as usize;
        let fitting = (width as f64 / wide).min(height as f64 / high_mm) * (1.0 - 2.0 * MARGIN);
        Self {
            left: 0.5 * (low[0] + high[0]) - 0.5 * width as f64 / fitting,
            top: 0.5 * (low[1] + high[1]) + 0.5 * height as f64 / fitting,
            scale: fitting * SAMPLES as f64,
            width,
            height,
        }
    }

    /// A point in samples from the upper left corner; z points towards the eye, also in samples.
    fn place(&self, point: &Point) -> Point {
        Point::new((point.x - self.left) * self.scale, (self.top - point.y) * self.scale, point.z * self.scale)
    }
}

/// The data of one sample.
#[derive(Clone, Copy)]
struct Seen {
    depth: f64,
    part: Option<u32>,
    normal: [f32; 3],
}

/// The samples of a picture.
struct Canvas {
    width: usize,
    height: usize,
    samples: Vec<Seen>,
}

impl Canvas {
    fn new(frame: &Frame) -> Self {
        let (width, height) = (frame.width * SAMPLES, frame.height * SAMPLES);
        let nothing = Seen { depth: f64::NEG_INFINITY, part: None, normal: [0.0; 3] };
        Self { width, height, samples: vec![nothing; width * height] }
    }

    /// Adds a triangle of a part, in the picture's frame, mm.
    fn add(&mut self, part: usize, triangle: &Triangle, frame: &Frame) {
        let Some(normal) = triangle.double_area_normal().try_normalize(0.0) else { return };
        // Faces of open meshes are seen from behind too.
        let normal = if normal.z < 0.0 { -normal } else { normal };
        let [a, b, c] = triangle.corners.map(|corner| frame.place(&corner));
        let area = cross(&a, &b, c.x, c.y);
        if area == 0.0 {
            return;
        }
        let span = |values: [f64; 3], most: usize| {
            let (low, high) = values.into_iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
            (low - 0.5).ceil().max(0.0) as usize..((high - 0.5).floor() + 1.0).clamp(0.0, most as f64) as usize
        };
        for row in span([a.y, b.y, c.y], self.height) {
            for column in span([a.x, b.x, c.x], self.width) {
                let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
                let weights = [cross(&b, &c, x, y) / area, cross(&c, &a, x, y) / area, cross(&a, &b, x, y) / area];
                if weights.iter().any(|&weight| weight < 0.0) {
                    continue;
                }
                let depth = weights[0] * a.z + weights[1] * b.z + weights[2] * c.z;
                let sample = &mut self.samples[row * self.width + column];
                if depth > sample.depth {
                    *sample =
                        Seen { depth, part: Some(part as u32), normal: [0, 1, 2].map(|axis| normal[axis] as f32) };
                }
            }
        }
    }

    /// Converts the samples to pixels.
    fn develop(&self, colours: &[Vector], step: f64) -> Image {
        let (width, height) = (self.width / SAMPLES, self.height / SAMPLES);
        let mut rgb = Vec::with_capacity(3 * width * height);
        for pixel in 0..width * height {
            let (row, column) = (pixel / width * SAMPLES, pixel % width * SAMPLES);
            let mut sum = Vector::zeros();
            for sample in 0..SAMPLES * SAMPLES {
                sum += self.shade(row + sample / SAMPLES, column + sample % SAMPLES, colours, step);
            }
            let mean = sum / (SAMPLES * SAMPLES) as f64;
            rgb.extend([0, 1, 2].map(|channel| (mean[channel].clamp(0.0, 1.0) * 255.0).round() as u8));
        }
        Image { width, height, rgb }
    }

    fn shade(&self, row: usize, column: usize, colours: &[Vector], step: f64) -> Vector {
        let here = self.samples[row * self.width + column];
        let light = here.part.map_or(1.0, |_| {
            let facing = vector(here.normal).dot(&Vector::from(LIGHT).normalize());
            0.62 + 0.38 * facing.max(0.0) + 0.08 * f64::from(here.normal[1])
        });
        let colour = here.part.map_or(Vector::repeat(1.0), |part| colours[part as usize]);
        let neighbours = [(row, column + 1), (row + 1, column), (row + 1, column + 1)];
        let edge = neighbours.into_iter().filter(|&(row, column)| row < self.height && column < self.width).any(
            |(row, column)| {
                let there = self.samples[row * self.width + column];
                there.part != here.part
                    || here.part.is_some()
                        && ((there.depth - here.depth).abs() > step + self.slope(&here).max(self.slope(&there))
                            || vector(here.normal).dot(&vector(there.normal)) < EDGE_COSINE)
            },
        );
        colour * (light * if edge { INK } else { 1.0 })
    }

    /// Largest change of the depth of a face from one sample to the next; infinite for a face seen edge-on.
    fn slope(&self, seen: &Seen) -> f64 {
        let [x, y, z] = seen.normal.map(f64::from);
        (x.abs() + y.abs()) / z.max(1e-3)
    }
}

fn vector(of: [f32; 3]) -> Vector {
    Vector::from(of.map(f64::from))
}

/// Twice the signed area of p, q and (x, y), samples².
fn cross(p: &Point, q: &Point, x: f64, y: f64) -> f64 {
    (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rs274::Position;

    /// A ball of 10 mm at the origin, and a smaller one 30 mm to its right (+x); both are examined.
    fn picture(view: &View) -> Image {
        let folder = tempfile::tempdir().unwrap();
        let scene = "title = \"\"\npairs = [[\"ball\", \"pill\"]]\n\
            [[machine.links]]\nname = \"slide\"\njoint = { axis = \"X\", direction = [1, 0, 0] }\n\
            [[parts]]\nname = \"ball\"\nrole = \"cutter\"\nshape = { kind = \"sphere\", radius_mm = 10 }\n\
            [[parts]]\nname = \"pill\"\nrole = \"workpiece\"\nlink = \"slide\"\nat = { xyz_mm = [30, 0, 0] }\n\
            shape = { kind = \"sphere\", radius_mm = 5 }\n";
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let scene = Scene::load(folder.path()).unwrap();
        take(&scene, &scene.machine.forward(&Position::default()), view).unwrap()
    }

    fn at(image: &Image, column: usize, row: usize) -> [u8; 3] {
        let start = 3 * (row * image.width + column);
        [0, 1, 2].map(|channel| image.rgb[start + channel])
    }

    #[test]
    fn parts_are_where_they_should_be_in_their_colours() {
        let view = View { width: 200, ..View::default() };
        let image = picture(&view);
        // From x -10 to 35: 45 mm in 200 px less 3 % on both sides, 4.18 px per mm. The flattest shape allowed is 2 to 1.
        assert_eq!((image.width, image.height), (200, 100));
        let column = |x: f64| (100.0 + (x - 12.5) * 188.0 / 45.0).round() as usize;
        let [red, _, blue] = at(&image, column(0.0), 50);
        assert!(red > 2 * blue, "the cutter is red");
        let [red, _, blue] = at(&image, column(30.0), 50);
        assert!(blue > 2 * red, "the workpiece is blue");
        assert_eq!(at(&image, column(20.0), 50), [255; 3]);
        assert_eq!(at(&image, column(30.0), 50 - 40), [255; 3]);
        assert_eq!(image, picture(&view));
    }

    #[test]
    fn the_eye_turns_counter_clockwise_and_the_nearer_part_hides_the_other() {
        // From the right: the small ball is before the large one.
        let image = picture(&View { width: 100, azimuth: std::f64::consts::FRAC_PI_2, ..View::default() });
        let [red, _, blue] = at(&image, 50, image.height / 2);
        assert!(blue > 2 * red);
        // From above, with Y up, nothing changes along x.
        let above = View { width: 200, up: Up::Y, elevation: 0.0, ..View::default() };
        assert_eq!(picture(&above).height, 100);
    }

    #[test]
    fn bad_views_are_refused() {
        let scene = Scene::find("lathe-toolpost").unwrap();
        let poses = scene.machine.forward(&Position::default());
        assert_eq!(take(&scene, &poses, &View::default()), Err(PictureError::Width(0)));
        let view = View { width: 100, azimuth: f64::NAN, ..View::default() };
        assert_eq!(take(&scene, &poses, &view), Err(PictureError::Direction));
    }
}
