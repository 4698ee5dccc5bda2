//! The checker on certificates that the search wrote, on ones written by hand, and on what is wrong with either.
//!
//! `../fixtures` holds two scenes with their certificates. To make these again, in that folder:
//!
//!     for scene in mill five-axis; do bvbench check $scene --clearance 0 --quiet --certify $scene/$scene.cert; done

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod bounds;
mod command;
mod files;
mod fixture;
mod interval;
mod tampered;
mod written;
