//! trueaxis
fn main() {}
