//! The remaining stock compared with the part that is wanted.
