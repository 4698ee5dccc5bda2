//! Watches a machine tool over OPC UA and holds it before it collides.
//!
//! Reading order: [`numbers`] (of the command line), [`judge`] (the rule: may the machine go on?), [`config`] (the TOML), [`play`] (a program with
//! accelerations), [`monitor`] (from readings to permission), `opc` (what client and server share), [`control`] (the simulated control),
//! [`log`], `outputs` (what is written), [`watch`] (the client), [`latency`] and [`figure`] (how long a verdict takes), [`soak`] with [`trace`], [`planted`] and [`relay`]
//! (long runs, planted collisions, kills, a bad network), [`claim`] (does real time hold?), [`panel`] (the operator's page).

pub mod numbers;
pub mod judge;
pub mod config;
pub mod play;
pub mod trace;
pub mod monitor;
mod opc;
pub mod control;
pub mod log;
mod outputs;
pub mod watch;
pub mod latency;
pub mod planted;
pub mod relay;
pub mod claim;
pub mod soak;
pub mod figure;
pub mod panel;
#[cfg(test)]
mod testing;
