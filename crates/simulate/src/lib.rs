//! Exact simulation of measuring campaigns on machine tools with known errors.
