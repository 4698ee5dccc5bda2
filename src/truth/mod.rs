//! Exact answers (placeholder).
