//! `identity`: what this binary was built from, for a run that would launch it.

use super::{CLEAR, say};
use crate::measure::environment;
use anyhow::Result;

/// Prints it as JSON.
pub fn run() -> Result<u8> {
    say(serde_json::to_string(&environment::identity())?);
    Ok(CLEAR)
}
