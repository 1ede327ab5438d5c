//! Why points or lines do not give what was asked of them.

/// Points that cannot be fitted or lines that cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Error {
    /// A fit was asked of too few points.
    #[error("{what}: need at least {need} points, found {found}")]
    TooFewPoints {
        what: &'static str,
        need: usize,
        found: usize,
    },
    /// A circle of a common axis has too few points to say anything about the axis.
    #[error("circle number {circle}: need at least {need} points on each circle, found {found}")]
    TooFewOnCircle {
        circle: usize,
        need: usize,
        found: usize,
    },
    /// A coordinate is infinite, not a number, or beyond 1e100 mm.
    #[error("point number {index} is not a finite position: [{x}, {y}, {z}]", x = point_mm[0], y = point_mm[1], z = point_mm[2])]
    NotFinite {
        /// Index of the point, counted through all circles.
        index: usize,
        point_mm: [f64; 3],
    },
    /// All points are the same within rounding.
    #[error(
        "{points} points coincide: they spread over {spread_mm:.1e} mm (rms), rounding alone \
         explains {rounding_mm:.1e} mm"
    )]
    Coincident {
        points: usize,
        /// Root mean square distance from the centroid, mm.
        spread_mm: f64,
        rounding_mm: f64,
    },
    /// The points of a line spread as far across it as along it.
    #[error(
        "the points have no main direction: they spread over {along_mm} mm (rms) in one direction \
         and over {across_mm} mm across it"
    )]
    NoMainDirection {
        /// Largest root mean square spread, mm.
        along_mm: f64,
        across_mm: f64,
    },
    /// The points of a circle lie on a line.
    #[error(
        "the points are collinear: along a line they spread over {length_mm} mm (rms), across it \
         over {width_mm:.1e} mm, of which rounding alone explains {rounding_mm:.1e} mm"
    )]
    Collinear {
        /// Root mean square spread along the line, mm.
        length_mm: f64,
        width_mm: f64,
        rounding_mm: f64,
    },
    /// The points leave a combination of the unknowns of a fit free, as those of a very short arc.
    #[error(
        "the circle is not determined by the points: the least singular value of its equations is \
         {singular_value:.1e} of the largest"
    )]
    Undetermined {
        /// The smallest relative singular value of the design matrix with unit columns.
        singular_value: f64,
    },
    /// A measured axis of rotation is nowhere near its nominal direction.
    #[error(
        "the measured axis makes {angle_deg} degrees with the nominal one, more than {limit_deg}: \
         it is another axis or its sense is reversed"
    )]
    FarFromNominal {
        /// The angle between the two directions, 0 to 180 degrees.
        angle_deg: f64,
        /// The largest angle accepted, degrees.
        limit_deg: f64,
    },
    /// The third line is too close to the plane of the other two for the paper's Eq. 23.
    #[error(
        "cos² alpha + cos² beta = {sum} with alpha, beta the angles of the z line to x and y; \
         the paper's equation 23 needs less than 1"
    )]
    PaperAngles { sum: f64 },
}
