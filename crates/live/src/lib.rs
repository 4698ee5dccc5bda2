//! Watches a machine tool over OPC UA and holds it before it collides.
//!
//! Reading order: [`judge`] (the rule: may the machine go on?), [`config`] (the TOML), [`play`] (a program with accelerations).

pub mod judge;
pub mod config;
pub mod play;
#[cfg(test)]
mod testing;
