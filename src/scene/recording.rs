//! Recorded poses: a CSV file of rigid motions, with one row per part and frame.
//!
//! The columns are `part`, then either `qw qx qy qz tx ty tz` (a unit quaternion and mm) or `m00 m01 ... m23` (the upper three rows of the
//! homogeneous matrix, mm in the last column). Both give `world_from_part`. A leading column `frame` groups rows: consecutive rows with the
//! same text are one frame. Without it, every row is a frame. A part keeps its pose until a row moves it.

use super::error::{Place, SceneError};
use crate::geometry::{Isometry, Vector};
use nalgebra::{Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion};
use std::path::Path;

/// Permitted deviation of a recorded rotation, per entry of RᵀR - 1 and for |q|² - 1. A file with six decimals deviates by up to 3·1e-6; a
/// scaled, sheared or mirrored matrix deviates by far more.
pub const ROTATION_TOLERANCE: f64 = 1e-4;

const QUATERNION: [&str; 7] = ["qw", "qx", "qy", "qz", "tx", "ty", "tz"];
const MATRIX: [&str; 12] = ["m00", "m01", "m02", "m03", "m10", "m11", "m12", "m13", "m20", "m21", "m22", "m23"];

/// `world_from_part` of every part, frame by frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The poses, per frame and per part of the scene.
    pub frames: Vec<Vec<Isometry>>,
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
}

/// Reads a recording.
///
/// # Errors
/// [`SceneError`] with file, line and column of the first error: an unknown header or part, a value that is not a finite number, an invalid
/// rotation, or a file without rows.
pub(super) fn parse(text: &str, file: &Path, parts: &[&str], initial: &[Isometry]) -> Result<Recording, SceneError> {
    let place = |line: usize, column: usize| Place { file: file.to_owned(), line, column };
    let meaning =
        |line: usize, column: usize, message: String| SceneError::Meaning { place: place(line, column), message };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
    let syntax = |error: &csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        SceneError::Syntax { place: place(line as usize, 1), message: error.to_string() }
    };
    let layout = Layout::of(reader.headers().map_err(|error| syntax(&error))?).ok_or_else(|| {
        let names = format!("part,{} or part,{}", QUATERNION.join(","), MATRIX.join(","));
        meaning(1, 1, format!("the columns must be {names}, after an optional frame"))
    })?;
    let first_number = 1 + usize::from(layout.has_frame);
    let mut frames: Vec<Vec<Isometry>> = Vec::new();
    let mut last_frame: Option<String> = None;
    for record in reader.records() {
        let record = record.map_err(|error| syntax(&error))?;
        let line = record.position().map_or(1, csv::Position::line) as usize;
        let part =
            parts.iter().position(|part| *part == &record[first_number - 1]).ok_or_else(|| SceneError::Unknown {
                place: place(line, first_number),
                what: "part",
                name: record[first_number - 1].to_owned(),
                known: parts.join(", "),
            })?;
        let mut numbers = Vec::with_capacity(12);
        for (index, field) in record.iter().enumerate().skip(first_number) {
            let number = field.parse::<f64>().ok().filter(|x| x.is_finite());
            numbers.push(number.ok_or_else(|| {
                meaning(line, index + 1, format!("`{field}` is not a finite number (column = field)"))
            })?);
        }
        let farthest = rs274::interpret::FARTHEST;
        if let Some(far) = numbers.iter().find(|x| x.abs() > farthest) {
            let message = format!("{far} is beyond {farthest:e} mm; is the unit right?");
            return Err(meaning(line, first_number + 1, message));
        }
        let pose = if layout.is_matrix { from_matrix(&numbers) } else { from_quaternion(&numbers) };
        let pose = pose.map_err(|message| meaning(line, first_number + 1, message.to_owned()))?;
        let frame = layout.has_frame.then(|| record[0].to_owned());
        if frames.is_empty() || frame.is_none() || frame != last_frame {
            frames.push(frames.last().map_or_else(|| initial.to_vec(), Clone::clone));
            last_frame = frame;
        }
        if let Some(current) = frames.last_mut() {
            current[part] = pose;
        }
    }
    if frames.is_empty() {
        return Err(meaning(1, 1, "there is no pose in the file".to_owned()));
    }
    Ok(Recording { frames })
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
            &["bed", "arm"],
            &[Isometry::translation(9.0, 0.0, 0.0), Isometry::identity()],
        )
    }

    #[test]
    fn without_frames_every_row_is_one_and_others_hold_their_pose() {
        let recording = read("part,qw,qx,qy,qz,tx,ty,tz\narm,1,0,0,0,1,2,3\n# a comment\nbed,1,0,0,0,0,0,5\n").unwrap();
        assert_eq!(recording.frames.len(), 2);
        assert_eq!(recording.frames[0][0].translation.x, 9.0);
        assert_eq!(recording.frames[1][0].translation.z, 5.0);
        assert_eq!(recording.frames[1][1].translation.y, 2.0);
    }

    #[test]
    fn frames_group_rows_and_matrices_are_rows_first() {
        // A quarter turn about z: x goes to y.
        let text = "frame,part,m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23\n\
                    0,arm,0,-1,0,10,1,0,0,20,0,0,1,30\n0,bed,1,0,0,0,0,1,0,0,0,0,1,0\n1,bed,1,0,0,7,0,1,0,0,0,0,1,0\n";
        let recording = read(text).unwrap();
        assert_eq!(recording.frames.len(), 2);
        let moved = recording.frames[1][1] * Point::new(1.0, 0.0, 0.0);
        assert!((moved - Point::new(10.0, 21.0, 30.0)).norm() < 1e-12);
        assert_eq!(recording.frames[1][0].translation.x, 7.0);
    }

    #[test]
    fn errors_name_file_and_line() {
        let q = "part,qw,qx,qy,qz,tx,ty,tz\n";
        for (text, message) in [
            ("part,x,y\n".to_owned(), "poses.csv:1:1: the columns must be"),
            (q.to_owned(), "poses.csv:1:1: there is no pose"),
            (format!("{q}leg,1,0,0,0,0,0,0\n"), "poses.csv:2:1: there is no part named `leg`; there are bed, arm"),
            (format!("{q}arm,1,0,0,0,0,0,0\narm,1,0,0,0,0,nan,0\n"), "poses.csv:3:7: `nan` is not a finite number"),
            (format!("{q}arm,2,0,0,0,0,0,0\n"), "poses.csv:2:2: the quaternion's length"),
            (format!("{q}arm,1,0,0\n"), "poses.csv:2:1: CSV error"),
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
