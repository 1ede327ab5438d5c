//! The kinds of campaigns that can be drawn.

/// What is common to all blind campaigns of a kind; the seed draws the rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kind {
    /// Machine, targets and sweeps.
    pub geometry: Geometry,
    /// Number of stations; four or more measure every point without redundancy to spare.
    pub stations: usize,
    /// How often all runs are measured from each station.
    pub repeats: u32,
    /// Whether every sweep goes back, too.
    pub both_directions: bool,
    /// Whether the axis moves on at constant feed while it is measured: a sweep for each target,
    /// one reading at each position.
    pub on_the_fly: bool,
    /// How often three targets on the bed are read from each station: at the start of its occupation, at its end, and
    /// between sweeps.
    pub bed_readings: usize,
    /// The noise that the campaign declares.
    pub declared: Noise,
    /// The noise that the lengths have.
    pub noise: Noise,
    /// Whether that of a length has Student's distribution with four degrees of freedom, scaled to its standard
    /// deviation, instead of the normal one.
    pub heavy_tails: bool,
}

/// Nominal geometry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Geometry {
    /// The paper's three-axis machine: X, Y, Z on the tool side, strokes 440, 400, 400 mm in steps
    /// of 20 mm, three targets carried by Z.
    ThreeAxis,
    /// The paper's rotary stage: C in steps of 20 degrees, three targets.
    RotaryStage,
    /// X, Y, Z on the tool side, A and C on the workpiece side, three targets on each, in wide steps.
    FiveAxis,
}

/// Standard deviations of the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Of a length, µm.
    pub length_um: f64,
    /// Per coordinate of the position that the machine returns to at a stop, µm; common to the
    /// targets measured there.
    pub return_um: f64,
}

/// The paper's tracker on a machine that returns to 1 µm.
impl Default for Noise {
    fn default() -> Self {
        Self {
            length_um: 0.269,
            return_um: 1.0,
        }
    }
}

impl Kind {
    /// The paper's three-axis machine from four stations, three times.
    pub fn three_axis() -> Self {
        Self {
            geometry: Geometry::ThreeAxis,
            stations: 4,
            repeats: 3,
            both_directions: false,
            on_the_fly: false,
            bed_readings: 0,
            declared: Noise::default(),
            noise: Noise::default(),
            heavy_tails: false,
        }
    }

    /// The paper's rotary stage from four stations, three times.
    pub fn rotary_stage() -> Self {
        Self {
            geometry: Geometry::RotaryStage,
            ..Self::three_axis()
        }
    }

    /// A five-axis machine from four stations, twice.
    pub fn five_axis() -> Self {
        Self {
            geometry: Geometry::FiveAxis,
            repeats: 2,
            ..Self::three_axis()
        }
    }

    /// The same from both sides of approach.
    #[must_use]
    pub fn forward_and_backward(self) -> Self {
        Self {
            both_directions: true,
            ..self
        }
    }

    /// The same with three targets on the bed, read so often from each station.
    #[must_use]
    pub fn with_bed(self, readings: usize) -> Self {
        Self {
            bed_readings: readings,
            ..self
        }
    }

    /// The same with noise that has heavy tails.
    #[must_use]
    pub fn with_heavy_tails(self) -> Self {
        Self {
            heavy_tails: true,
            ..self
        }
    }

    /// The same from both sides, at constant feed.
    #[must_use]
    pub fn on_the_fly(self) -> Self {
        Self {
            on_the_fly: true,
            ..self.forward_and_backward()
        }
    }
}
