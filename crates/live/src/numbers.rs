//! Numbers of the command line, within their limits.

/// Longest time that may be asked for, s.
pub const YEAR_S: f64 = 365.0 * 86_400.0;

/// Reads a share, 0 to 1.
///
/// # Errors
/// When the text is no number, or not a share.
pub fn share(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err(format!("{value} is not between 0 and 1")) }
}

/// Reads a number from 0 to `most`, which is of a unit.
pub fn between(most: f64, unit: &'static str) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let value: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
        let is_within = (0.0..=most).contains(&value);
        if is_within { Ok(value) } else { Err(format!("{value} {unit} are not between 0 and {most}")) }
    }
}
