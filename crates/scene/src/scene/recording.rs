//! Recorded poses: a CSV file of rigid motions, with one row per part and frame.
//!
//! The columns are `part`, then either `qw qx qy qz tx ty tz` (a unit quaternion and mm) or `m00 m01 ... m23` (the upper three rows of the
//! homogeneous matrix, mm in the last column). Both give `world_from_part`. A leading column `frame` groups rows: consecutive rows with the
//! same text are one frame, which names a part once. Without it, every row is a frame. A part keeps its pose until a row moves it. Lines that
//! begin with `#` are comments.

use super::error::{Place, SceneError};
use super::load::unknown;
use crate::geometry::{Isometry, Vector};
use nalgebra::{Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion};
use std::collections::HashSet;
use std::path::Path;

/// Permitted deviation of a recorded rotation, per entry of RᵀR - 1 and for |q|² - 1. A file with six decimals deviates by up to 3·1e-6; a
/// scaled, sheared or mirrored matrix deviates by far more.
pub const ROTATION_TOLERANCE: f64 = 1e-4;

const QUATERNION: [&str; 7] = ["qw", "qx", "qy", "qz", "tx", "ty", "tz"];
const MATRIX: [&str; 12] = ["m00", "m01", "m02", "m03", "m10", "m11", "m12", "m13", "m20", "m21", "m22", "m23"];

/// `world_from_part` of every part, frame by frame. It takes memory for the poses that are added, not for all parts in all frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    frames: usize,
    /// By part of the scene.
    tracks: Vec<Track>,
}

/// The poses of a part.
#[derive(Clone, Debug, PartialEq)]
struct Track {
    initial: Isometry,
    /// The frames in which it moves, in order, and its poses from there on.
    moves: Vec<(usize, Isometry)>,
}

impl Recording {
    /// A recording without frames; `initial` holds the pose of each part until it moves.
    pub fn new(initial: &[Isometry]) -> Self {
        let tracks = initial.iter().map(|&initial| Track { initial, moves: Vec::new() }).collect();
        Self { frames: 0, tracks }
    }

    /// Number of frames.
    pub const fn frames(&self) -> usize {
        self.frames
    }

    /// Begins a frame in which all parts are where they were.
    pub const fn begin_frame(&mut self) {
        self.frames += 1;
    }

    /// Moves a part in the last frame; `false` when it has been moved in that frame.
    pub fn add(&mut self, part: usize, pose: Isometry) -> bool {
        let (frame, moves) = (self.frames.saturating_sub(1), &mut self.tracks[part].moves);
        let is_first = moves.last().is_none_or(|(moved, _)| *moved < frame);
        if is_first {
            moves.push((frame, pose));
        }
        is_first
    }

    /// `world_from_part` of a part in a frame, counted from 0.
    pub fn pose(&self, part: usize, frame: usize) -> Isometry {
        let Track { initial, moves } = &self.tracks[part];
        let after = moves.partition_point(|(moved, _)| *moved <= frame);
        moves[..after].last().map_or(*initial, |(_, pose)| *pose)
    }
}

/// The columns that a file has.
struct Layout {
    has_frame: bool,
    is_matrix: bool,
}

impl Layout {
    fn of(header: &csv::StringRecord) -> Option<Self> {
        let names: Vec<&str> = header.iter().map(str::trim).collect();
        let has_frame = names.first() == Some(&"frame");
        let names = if has_frame { &names[1..] } else { &names[..] };
        let (&part, numbers) = names.split_first()?;
        let is_matrix = numbers == MATRIX;
        (part == "part" && (is_matrix || numbers == QUATERNION)).then_some(Self { has_frame, is_matrix })
    }

    /// The pose of a row.
    ///
    /// # Errors
    /// The column of what is wrong, and what it is.
    fn pose(&self, record: &csv::StringRecord) -> Result<Isometry, (usize, String)> {
        let first = 1 + usize::from(self.has_frame);
        let mut numbers = Vec::with_capacity(12);
        for (index, field) in record.iter().enumerate().skip(first) {
            let number = field.parse::<f64>().ok().filter(|x| x.is_finite());
            let wrong = || (index + 1, format!("`{field}` is not a finite number (column = field)"));
            numbers.push(number.ok_or_else(wrong)?);
        }
        let farthest = rs274::interpret::FARTHEST;
        if let Some(far) = numbers.iter().find(|x| x.abs() > farthest) {
            return Err((first + 1, format!("{far} is beyond {farthest:e} mm; is the unit right?")));
        }
        let pose = if self.is_matrix { from_matrix(&numbers) } else { from_quaternion(&numbers) };
        pose.map_err(|message| (first + 1, message.to_owned()))
    }
}

/// Reads a recording.
///
/// # Errors
/// [`SceneError`] with file, line and column of the first error: an unknown header or part, a value that is not a finite number, an invalid
/// rotation, a second row of a part in one frame, a frame that comes again after another, or a file without rows.
pub(super) fn parse(text: &str, file: &Path, parts: &[&str], initial: &[Isometry]) -> Result<Recording, SceneError> {
    let place = |line: usize, column: usize| Place { file: file.to_owned(), line, column };
    let meaning = |line: usize, column: usize, message: String| place(line, column).error(message);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
    let syntax = |error: &csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        place(line as usize, 1).error(error)
    };
    let layout = Layout::of(reader.headers().map_err(|error| syntax(&error))?).ok_or_else(|| {
        let names = format!("part,{} or part,{}", QUATERNION.join(","), MATRIX.join(","));
        meaning(1, 1, format!("the first row must name the columns: {names}, after an optional frame"))
    })?;
    let part_at = usize::from(layout.has_frame);
    let names_part = |line: &str| line.split(',').nth(part_at).is_some_and(|name| parts.contains(&name.trim()));
    if let Some(index) = text.lines().position(|line| line.starts_with('#') && names_part(line)) {
        let message = "this comment reads as a row; put its first cell in quotation marks, or remove it";
        return Err(meaning(index + 1, 1, message.to_owned()));
    }
    let mut recording = Recording::new(initial);
    let mut seen: HashSet<String> = HashSet::new();
    let mut last_frame: Option<String> = None;
    for record in reader.records() {
        let record = record.map_err(|error| syntax(&error))?;
        let line = record.position().map_or(1, csv::Position::line) as usize;
        let name = &record[part_at];
        let part = parts.iter().position(|part| *part == name);
        let part = part.ok_or_else(|| unknown(place(line, part_at + 1), "part", name, parts.iter().copied()))?;
        let pose = layout.pose(&record).map_err(|(column, message)| meaning(line, column, message))?;
        let frame = layout.has_frame.then(|| record[0].to_owned());
        if frame.is_none() || frame != last_frame {
            if let Some(frame) = &frame
                && !seen.insert(frame.clone())
            {
                let message = format!("frame `{frame}` comes again after another; sort the rows by frame");
                return Err(meaning(line, 1, message));
            }
            recording.begin_frame();
            last_frame = frame;
        }
        if !recording.add(part, pose) {
            return Err(meaning(line, part_at + 1, format!("`{name}` has a pose in this frame already")));
        }
    }
    if recording.frames() == 0 {
        return Err(meaning(1, 1, "there is no pose in the file".to_owned()));
    }
    Ok(recording)
}

fn from_quaternion(numbers: &[f64]) -> Result<Isometry, &'static str> {
    let quaternion = Quaternion::new(numbers[0], numbers[1], numbers[2], numbers[3]);
    if (quaternion.norm_squared() - 1.0).abs() > ROTATION_TOLERANCE {
        return Err("the quaternion's length is not 1");
    }
    let translation = Translation3::new(numbers[4], numbers[5], numbers[6]);
    Ok(Isometry::from_parts(translation, UnitQuaternion::from_quaternion(quaternion)))
}

fn from_matrix(numbers: &[f64]) -> Result<Isometry, &'static str> {
    let entry = |row: usize, column: usize| numbers[4 * row + column];
    let rotation = Matrix3::from_fn(entry);
    if (rotation.transpose() * rotation - Matrix3::identity()).amax() > ROTATION_TOLERANCE {
        return Err("the matrix is not a rotation: its columns are not unit vectors at right angles");
    }
    if rotation.determinant() < 0.0 {
        return Err("the matrix is not a rotation: it mirrors");
    }
    // Through a quaternion, which makes the rotation exactly orthonormal again.
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    let translation = Translation3::from(Vector::new(entry(0, 3), entry(1, 3), entry(2, 3)));
    Ok(Isometry::from_parts(translation, rotation))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    fn read(text: &str) -> Result<Recording, SceneError> {
        parse(
            text,
            Path::new("poses.csv"),
            &["bed", "arm", "#clamp"],
            &[Isometry::translation(9.0, 0.0, 0.0), Isometry::identity(), Isometry::identity()],
        )
    }

    #[test]
    fn without_frames_every_row_is_one_and_others_hold_their_pose() {
        let recording = read("part,qw,qx,qy,qz,tx,ty,tz\narm,1,0,0,0,1,2,3\n# a comment\nbed,1,0,0,0,0,0,5\n").unwrap();
        assert_eq!(recording.frames(), 2);
        assert_eq!(recording.pose(0, 0).translation.x, 9.0);
        assert_eq!(recording.pose(0, 1).translation.z, 5.0);
        assert_eq!([0, 1].map(|frame| recording.pose(1, frame).translation.y), [2.0, 2.0]);
    }

    #[test]
    fn frames_group_rows_and_matrices_are_rows_first() {
        // A quarter turn about z: x goes to y.
        let text = "frame,part,m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23\n\
                    0,arm,0,-1,0,10,1,0,0,20,0,0,1,30\n0,bed,1,0,0,0,0,1,0,0,0,0,1,0\n1,bed,1,0,0,7,0,1,0,0,0,0,1,0\n";
        let recording = read(text).unwrap();
        assert_eq!(recording.frames(), 2);
        let moved = recording.pose(1, 1) * Point::new(1.0, 0.0, 0.0);
        assert!((moved - Point::new(10.0, 21.0, 30.0)).norm() < 1e-12);
        assert_eq!([0, 1].map(|frame| recording.pose(0, frame).translation.x), [0.0, 7.0]);
    }

    #[test]
    fn a_name_in_quotation_marks_may_begin_as_a_comment() {
        let text = "part,qw,qx,qy,qz,tx,ty,tz\n\"#clamp\",1,0,0,0,1,2,3\n#arm,1,0,0,0,9,9,9\n";
        let recording = read(text).unwrap();
        assert_eq!((recording.frames(), recording.pose(2, 0).translation.z), (1, 3.0));
    }

    #[test]
    fn errors_name_file_and_line() {
        let (q, one) = ("part,qw,qx,qy,qz,tx,ty,tz\n", "1,0,0,0,0,0,0\n");
        for (text, message) in [
            (
                "part,x,y\n".to_owned(),
                "poses.csv:1:1: the first row must name the columns: part,qw,qx,qy,qz,tx,ty,tz or",
            ),
            ("a,1,0,0,0,0,0,0\n".to_owned(), "poses.csv:1:1: the first row must name the columns"),
            (q.to_owned(), "poses.csv:1:1: there is no pose"),
            (
                format!("{q}leg,1,0,0,0,0,0,0\n"),
                "poses.csv:2:1: there is no part named `leg`; there are bed, arm, #clamp",
            ),
            (format!("{q}arm,1,0,0,0,0,0,0\narm,1,0,0,0,0,nan,0\n"), "poses.csv:3:7: `nan` is not a finite number"),
            (format!("{q}arm,2,0,0,0,0,0,0\n"), "poses.csv:2:2: the quaternion's length"),
            (format!("{q}arm,1,0,0\n"), "poses.csv:2:1: CSV error"),
            (format!("{q}bed,{one}#arm,{one}# arm, too\n#clamp,{one}"), "poses.csv:5:1: this comment reads as a row"),
            (format!("frame,{q}1,arm,{one}1,bed,{one}1,arm,{one}"), "poses.csv:4:2: `arm` has a pose in this frame"),
            (format!("frame,{q},arm,{one},arm,{one}"), "poses.csv:3:2: `arm` has a pose in this frame already"),
            (format!("frame,{q}1,arm,{one}2,arm,{one}1,bed,{one}"), "poses.csv:4:1: frame `1` comes again"),
            (format!("frame,{q}#1,arm,{one}"), "poses.csv:2:1: this comment reads as a row"),
            (format!("frame,{q}arm,{one}"), "poses.csv:2:1: CSV error"),
        ] {
            let error = read(&text).unwrap_err().to_string();
            assert!(error.starts_with(message), "{error}");
        }
        let m = "part,m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23\n";
        let mirror = read(&format!("{m}arm,-1,0,0,0,0,1,0,0,0,0,1,0\n")).unwrap_err().to_string();
        assert!(mirror.contains("it mirrors"), "{mirror}");
        let scaled = read(&format!("{m}arm,2,0,0,0,0,2,0,0,0,0,2,0\n")).unwrap_err().to_string();
        assert!(scaled.contains("not unit vectors"), "{scaled}");
    }
}
