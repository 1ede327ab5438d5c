//! `covariance.npy` and `covariance.json`.

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_predict::OutputCovariance;

use crate::{simulated, two_branches};

fn covariance() -> OutputCovariance {
    let mut settings = Settings {
        covariance: true,
        ..Settings::default()
    };
    settings.poses.by_direction = true;
    let calibration = calibrate(&simulated(&two_branches()), &settings).unwrap();
    calibration.covariance.unwrap()
}

#[test]
fn the_index_names_every_row_with_its_unit() {
    let covariance = covariance();
    let index = covariance.index_json();
    let entry = |fields: &str| format!("{{\n    {}\n  }}", fields.replace(", ", ",\n    "));
    for fields in [
        r#""name": "EYX", "axis": "X", "position": 210.0, "direction": -1, "unit": "um""#,
        r#""name": "EAC", "axis": "C", "position": 75.0, "direction": 1, "unit": "arcsec""#,
        r#""name": "C0Y", "axis": "Y", "unit": "arcsec""#,
        r#""name": "X0C", "axis": "C", "unit": "mm""#,
        r#""name": "z", "station": "S4", "unit": "mm""#,
        r#""name": "dead_path", "station": "S1", "unit": "mm""#,
    ] {
        assert_eq!(
            index.matches(&entry(fields)).count(),
            1,
            "{fields}\n{index}"
        );
    }
    let names = index.matches("\"name\"").count();
    assert_eq!(names, covariance.outputs.len());
    assert_eq!(names, covariance.matrix.nrows());
}

#[test]
fn the_matrix_is_the_end_of_its_file() {
    let covariance = covariance();
    let bytes = covariance.to_npy();
    let count = covariance.matrix.len();
    let first = bytes.len() - 8 * count;
    let header = String::from_utf8_lossy(&bytes[..first]);
    let size = covariance.outputs.len();
    assert!(header.contains(&format!("({size}, {size})")), "{header}");
    let (elements, rest) = bytes[first..].as_chunks::<8>();
    assert!(rest.is_empty());
    for (k, element) in elements.iter().enumerate() {
        let expected = covariance.matrix[(k / size, k % size)];
        assert_eq!(f64::from_le_bytes(*element).to_bits(), expected.to_bits());
    }
}

#[test]
fn without_being_asked_there_is_none() {
    let mut settings = Settings::default();
    settings.poses.by_direction = true;
    let calibration = calibrate(&simulated(&two_branches()), &settings).unwrap();
    assert!(calibration.covariance.is_none());
}
