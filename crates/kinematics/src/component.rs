//! Names of the six component errors (ISO 230-1).

/// One of the six component errors of an axis.
///
/// ISO 230-1 names them `E`, direction, axis: `EXX` is the positioning error of X, `EBX` its
/// pitch. In the paper's order they are δx δy δz εx εy εz.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Component {
    /// Translation along x.
    X,
    /// Translation along y.
    Y,
    /// Translation along z.
    Z,
    /// Rotation about x.
    A,
    /// Rotation about y.
    B,
    /// Rotation about z.
    C,
}

impl Component {
    /// All six in the order of [`crate::MotionError::to_vector`].
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::A, Self::B, Self::C];

    /// Its place in [`Component::ALL`].
    pub fn index(self) -> usize {
        self as usize
    }

    /// Whether it is a rotation (A, B, C).
    pub fn is_angular(self) -> bool {
        self.index() >= 3
    }

    /// `X` to `C`.
    pub fn letter(self) -> char {
        ['X', 'Y', 'Z', 'A', 'B', 'C'][self.index()]
    }

    /// ISO 230-1 name for the axis `axis`, such as `EXC`.
    pub fn name(self, axis: &str) -> String {
        format!("E{}{axis}", self.letter())
    }
}
