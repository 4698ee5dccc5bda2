//! Markdown tables and the numbers in them.

use std::fmt::Write;

/// A table under construction.
#[derive(Debug)]
pub struct Table {
    text: String,
}

impl Table {
    /// A table with these headings; columns whose heading begins with `>` are aligned right.
    pub fn new<S: AsRef<str>>(headings: &[S]) -> Self {
        let headings = || headings.iter().map(AsRef::as_ref);
        let mut table = Self { text: String::new() };
        table.row(headings().map(|heading| heading.trim_start_matches('>')));
        table.row(headings().map(|heading| if heading.starts_with('>') { "---:" } else { "---" }));
        table
    }

    /// Adds a row. Characters that would end a cell or a line are escaped.
    pub fn row<S: AsRef<str>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.text.push('|');
        for cell in cells {
            let cell = cell.as_ref().replace('|', "\\|").replace('\n', " ");
            write!(self.text, " {cell} |").expect("writing to a String cannot fail");
        }
        self.text.push('\n');
    }

    /// The finished table.
    pub fn finish(self) -> String {
        self.text + "\n"
    }
}

/// A number with three significant digits, or more if its integer part has more; `-` when it is not a number.
pub fn number(value: f64) -> String {
    match value.abs() {
        _ if !value.is_finite() => "-".to_owned(),
        0.0 => "0".to_owned(),
        x if x >= 100.0 => format!("{value:.0}"),
        x if x >= 10.0 => format!("{value:.1}"),
        x if x >= 0.1 => format!("{value:.3}"),
        x if x >= 1e-3 => format!("{value:.4}"),
        _ => format!("{value:.1e}"),
    }
}

/// An upper bound, a positive number in the digits of [`number`], rounded upwards: a bound must not be told as less than it is.
pub fn bound(value: f64) -> String {
    let shown = number(value);
    if !shown.parse().is_ok_and(|near: f64| near < value) {
        return shown;
    }
    let unit = match value {
        x if x >= 100.0 => 1.0,
        x if x >= 10.0 => 0.1,
        x if x >= 0.1 => 1e-3,
        x if x >= 1e-3 => 1e-4,
        x => 10_f64.powf(x.log10().floor() - 1.0),
    };
    number(value + 0.5 * unit)
}

/// A value with its interval, as far as they are given and are numbers.
pub fn interval(value: Option<f64>, low: Option<f64>, high: Option<f64>) -> String {
    let known = |end: Option<f64>| end.filter(|end| end.is_finite());
    match (value, known(low), known(high)) {
        (Some(value), Some(low), Some(high)) => format!("{} [{}, {}]", number(value), number(low), number(high)),
        (Some(value), ..) => number(value),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let shown = [0.0, 1234.5, 12.34, 0.8, 0.012_34, 1e-5, f64::NAN].map(number);
        assert_eq!(shown, ["0", "1234", "12.3", "0.800", "0.0123", "1.0e-5", "-"]);
        assert_eq!(interval(Some(0.8), Some(0.75), Some(0.85)), "0.800 [0.750, 0.850]");
        assert_eq!(interval(None, None, None), "");
        assert_eq!(interval(Some(0.8), Some(f64::NAN), Some(f64::NAN)), "0.800");
    }

    #[test]
    fn bounds_are_rounded_upwards() {
        let values = [1234.5, 12.31, 0.3, 0.2143, 0.100_01, 0.012_31, 1.84e-4, 9.91e-5, 2e-4, 1.0, f64::NAN];
        let shown = ["1235", "12.4", "0.300", "0.215", "0.101", "0.0124", "1.9e-4", "1.0e-4", "2.0e-4", "1.000", "-"];
        assert_eq!(values.map(bound), shown);
    }

    #[test]
    fn cells_cannot_break_the_table() {
        let mut table = Table::new(&["a", ">b"]);
        table.row(["x|y", "1\n2"]);
        assert_eq!(table.finish(), "| a | b |\n| --- | ---: |\n| x\\|y | 1 2 |\n\n");
    }
}
