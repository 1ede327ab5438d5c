//! Average lines, circles and axes of rotation by least squares.
