//! Tests of the page: what it shows, and that nothing in the files breaks it.

mod colours;
mod hostile;
mod shows;
