//! Any record as a table of cells with the lines they stand on, for readers that want to name their source.

use super::file::{self, RecordError};
use super::rows::Row;
use serde::Serialize;
use serde_json::Value;
use std::path::Path;

/// A record: its columns, and of each row the line in the file followed by the cells. Numbers are numbers; what is empty or
/// no number (`NaN`) is null.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    /// The file's name.
    pub file: String,
    /// Its columns.
    pub columns: Vec<String>,
    /// Line (from 1), then a cell per column.
    pub rows: Vec<Vec<Value>>,
}

impl Table {
    /// Reads the row type's file in `folder`; every row must be of the type.
    ///
    /// # Errors
    /// When the file is missing or a row is not of its type.
    pub fn of<R: Row>(folder: &Path) -> Result<Self, RecordError> {
        let path = file::located(folder, R::FILE);
        let bad = |source| RecordError::Csv { path: path.clone(), source };
        let mut reader = csv::Reader::from_reader(file::open_table(folder, R::FILE)?);
        let headers = reader.headers().map_err(bad)?.clone();
        let mut rows = Vec::new();
        let mut record = csv::StringRecord::new();
        while reader.read_record(&mut record).map_err(bad)? {
            let line = record.position().map_or(0, csv::Position::line);
            let row: R = record.deserialize(Some(&headers)).map_err(bad)?;
            let cells =
                serde_json::to_value(&row).map_err(|source| RecordError::Json { path: path.clone(), source })?;
            let cell = |column: &str| cells.get(column).cloned().unwrap_or(Value::Null);
            rows.push(std::iter::once(line.into()).chain(headers.iter().map(cell)).collect());
        }
        Ok(Self { file: R::FILE.to_owned(), columns: headers.iter().map(str::to_owned).collect(), rows })
    }

    /// Reads any CSV in `folder`: a column whose cells are all numbers, or empty, holds numbers. Scenes are names, also where these are
    /// digits.
    ///
    /// # Errors
    /// When the file is missing or no CSV.
    pub fn of_file(folder: &Path, file: &str) -> Result<Self, RecordError> {
        let path = file::located(folder, file);
        let bad = |source| RecordError::Csv { path: path.clone(), source };
        let mut reader = csv::Reader::from_reader(file::open_table(folder, file)?);
        let columns: Vec<String> = reader.headers().map_err(bad)?.iter().map(str::to_owned).collect();
        let records: Vec<csv::StringRecord> = reader.records().collect::<Result<_, _>>().map_err(bad)?;
        let is_number = |cell: &str| cell.is_empty() || cell.parse::<f64>().is_ok();
        let is_numeric = |(i, column): (usize, &String)| {
            column != "scene" && records.iter().all(|record| record.get(i).is_none_or(is_number))
        };
        let numeric: Vec<bool> = columns.iter().enumerate().map(is_numeric).collect();
        let cell = |(cell, numeric): (&str, &bool)| match cell {
            "" => Value::Null,
            _ if *numeric => {
                cell.parse::<u64>().map_or_else(|_| cell.parse::<f64>().unwrap_or(f64::NAN).into(), Value::from)
            }
            text => text.into(),
        };
        let row = |record: &csv::StringRecord| {
            let line = record.position().map_or(0, csv::Position::line);
            std::iter::once(line.into()).chain(record.iter().zip(&numeric).map(cell)).collect()
        };
        Ok(Self { file: file.to_owned(), rows: records.iter().map(row).collect(), columns })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{ClaimRow, write_rows, write_text};
    use serde_json::json;

    fn claim(note: &str) -> ClaimRow {
        ClaimRow {
            claim: "faster".into(),
            role: "primary".into(),
            reading: "1".into(),
            scene: "s".into(),
            workload: "w".into(),
            stratum: "all".into(),
            verdict: "refuted".into(),
            effect: "more".into(),
            p_holm: None,
            measure: "m".into(),
            value: Some(1.5),
            low: Some(f64::NAN),
            high: None,
            missed: Some(3),
            baseline_missed: None,
            note: note.into(),
        }
    }

    /// The head is line 1; a note of two lines moves what follows it from line 3 to line 4. A text stays one though it is `1`.
    #[test]
    fn rows_know_their_lines() {
        let folder = tempfile::TempDir::new().unwrap();
        write_rows(folder.path(), &[claim("two\nlines"), claim("")]).unwrap();
        let table = Table::of::<ClaimRow>(folder.path()).unwrap();
        assert_eq!((table.columns.len(), table.columns[1].as_str()), (16, "role"));
        let first = json!([
            2,
            "faster",
            "primary",
            "1",
            "s",
            "w",
            "all",
            "refuted",
            "more",
            "m",
            1.5,
            null,
            null,
            null,
            3,
            null,
            "two\nlines"
        ]);
        assert_eq!(json!(table.rows[0]), first);
        assert_eq!(table.rows[1][0], 4);
        let text = std::fs::read_to_string(folder.path().join("claims.csv")).unwrap();
        assert!(text.lines().nth(3).unwrap().starts_with("faster,primary,1,s"), "{text}");
    }

    #[test]
    fn a_file_of_no_known_type_has_numbers_where_all_are() {
        let folder = tempfile::TempDir::new().unwrap();
        write_text(&folder.path().join("x.csv"), "name,n,mixed,scene\na,1,1,7\nb,-2.5,x,7\nc,,2,8\nd,NaN,,8\n")
            .unwrap();
        let table = Table::of_file(folder.path(), "x.csv").unwrap();
        let rows = json!([
            [2, "a", 1, "1", "7"],
            [3, "b", -2.5, "x", "7"],
            [4, "c", null, "2", "8"],
            [5, "d", null, null, "8"]
        ]);
        assert_eq!(json!(table.rows), rows);
        write_text(&folder.path().join("x.csv"), "a,b\n1\n").unwrap();
        assert!(Table::of_file(folder.path(), "x.csv").unwrap_err().to_string().contains("line: 2"));
    }
}
