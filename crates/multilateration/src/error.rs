//! What keeps lengths from becoming points.

/// Lengths that cannot be adjusted. Indices refer to the [`crate::Network`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Error {
    /// Too few stations to find stations and points together.
    #[error("self-calibration needs at least {need} stations, found {found}")]
    TooFewStations { need: usize, found: usize },
    /// A station of the network has no readings.
    #[error("station {station} has no readings")]
    StationWithoutReadings { station: usize },
    /// A point is seen from too few stations.
    #[error(
        "point {point} of group {group} is seen from fewer stations than needed: {seen} of at least {need}"
    )]
    PointSeenTooRarely {
        group: usize,
        point: usize,
        seen: usize,
        need: usize,
    },
    /// The beams to a point lie so that a direction of the point is free.
    #[error(
        "point {point} of group {group}: the beams that meet there lie in one plane (pivot \
         {pivot:.1e}, limit {limit:.1e})"
    )]
    PointNotDetermined {
        group: usize,
        point: usize,
        /// Relative size of what determines the free direction.
        pivot: f64,
        limit: f64,
    },
    /// The points of a group do not show how its body is turned.
    #[error(
        "group {group}: number of points {points}; a rigid body needs three that are not in line"
    )]
    NotRigid { group: usize, points: usize },
    /// The lengths to the points of a group leave a motion of its body free.
    #[error(
        "group {group}: its {lengths} lengths leave a motion of the body free (pivot {pivot:.1e}, limit \
         {limit:.1e})"
    )]
    PoseNotDetermined {
        group: usize,
        lengths: usize,
        /// Relative size of what determines the free motion.
        pivot: f64,
        limit: f64,
    },
    /// The lengths leave the shape of a body open.
    #[error(
        "the lengths do not determine the shape of body {body} (relative eigenvalue {eigenvalue:.1e}, \
         limit {limit:.1e})"
    )]
    ShapeNotDetermined {
        body: usize,
        eigenvalue: f64,
        limit: f64,
    },
    /// The lengths leave the constants of the reflectors open.
    #[error(
        "the lengths do not determine how the constants of the reflectors differ (relative eigenvalue \
         {eigenvalue:.1e}, limit {limit:.1e})"
    )]
    ReflectorsNotDetermined { eigenvalue: f64, limit: f64 },
    /// Fewer readings than unknowns.
    #[error("{readings} lengths cannot determine {unknowns} unknowns")]
    TooFewReadings {
        readings: usize,
        /// Unknowns less the six of the datum.
        unknowns: usize,
    },
    /// No position of the station explains its lengths.
    #[error(
        "station {station}: no position explains its lengths (best rms {rms_mm:.3} mm over \
         {readings} readings)"
    )]
    NoStart {
        station: usize,
        readings: usize,
        rms_mm: f64,
    },
    /// The lengths do not determine the stations.
    #[error(
        "the lengths leave the stations free (free combinations: {defect}; relative \
         eigenvalue {eigenvalue:.1e}, limit {limit:.1e})"
    )]
    StationsNotDetermined {
        /// Free combinations beyond position and orientation of the whole.
        defect: usize,
        eigenvalue: f64,
        limit: f64,
        /// The unknowns that take part, largest share first.
        free: Vec<StationUnknown>,
    },
    /// The start determined all stations, the adjustment did not: contradictory lengths drove a station away.
    #[error(
        "the adjustment ran away from its start: the lengths contradict each other (reading {reading} \
         is {residual_mm:.3} mm off at the start)"
    )]
    RanAway { reading: usize, residual_mm: f64 },
    /// The network contradicts itself: an index out of range or a number that is not finite.
    #[error("the network is malformed: {what}")]
    Malformed { what: String },
    /// The least-squares machinery failed.
    #[error("the adjustment failed")]
    LeastSquares(#[source] trueaxis_leastsquares::Error),
}

impl Error {
    /// That the network contradicts itself.
    pub(crate) fn malformed(what: impl Into<String>) -> Self {
        Self::Malformed { what: what.into() }
    }
}

/// One of the four unknowns of a station.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StationUnknown {
    /// The station.
    pub station: usize,
    /// 0, 1, 2 for x, y, z; 3 for the dead path.
    pub unknown: usize,
}
