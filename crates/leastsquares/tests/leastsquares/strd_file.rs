//! Reads the `.dat` files of NIST's nonlinear regression sets.

use std::path::Path;

/// One set: data, two starts, certified answers.
pub(crate) struct Set {
    pub(crate) name: &'static str,
    /// Response and predictors, one row for each observation.
    pub(crate) rows: Vec<Row>,
    /// Start 1 (far) and start 2 (near).
    pub(crate) starts: [Vec<f64>; 2],
    pub(crate) certified: Certified,
}

pub(crate) struct Row {
    pub(crate) response: f64,
    pub(crate) predictors: Vec<f64>,
}

pub(crate) struct Certified {
    pub(crate) unknowns: Vec<f64>,
    /// Standard deviations of the unknowns.
    pub(crate) deviations: Vec<f64>,
    /// Residual sum of squares.
    pub(crate) squares: f64,
}

impl Set {
    pub(crate) fn read(name: &'static str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("tests/nist_strd")
            .join(format!("{name}.dat"));
        let text = std::fs::read_to_string(&path).expect("the file of the set");
        let mut set = Self {
            name,
            rows: Vec::new(),
            starts: [Vec::new(), Vec::new()],
            certified: Certified {
                unknowns: Vec::new(),
                deviations: Vec::new(),
                squares: f64::NAN,
            },
        };
        let mut observations = None;
        let mut lines = text.lines();
        for line in lines.by_ref() {
            // The description starts with "Data:", too, but there "1 Response" follows.
            if line
                .strip_prefix("Data:")
                .is_some_and(|rest| rest.trim_start().starts_with('y'))
            {
                break;
            }
            if let Some((name, values)) = line.split_once('=')
                && name.trim().strip_prefix('b').is_some_and(is_number)
            {
                let values = numbers(values);
                let [start1, start2, value, deviation] = values[..] else {
                    panic!("{path:?}: start 1, start 2, value, deviation in {line:?}");
                };
                set.starts[0].push(start1);
                set.starts[1].push(start2);
                set.certified.unknowns.push(value);
                set.certified.deviations.push(deviation);
            } else if let Some(value) = line.strip_prefix("Residual Sum of Squares:") {
                set.certified.squares = numbers(value)[0];
            } else if let Some(value) = line.strip_prefix("Number of Observations:") {
                observations = Some(value.trim().parse::<usize>().expect("a count"));
            }
        }
        for line in lines.filter(|line| !line.trim().is_empty()) {
            let values = numbers(line);
            set.rows.push(Row {
                response: values[0],
                predictors: values[1..].to_vec(),
            });
        }
        assert_eq!(Some(set.rows.len()), observations, "{name}: all rows");
        assert!(set.certified.squares.is_finite() && !set.certified.unknowns.is_empty());
        set
    }
}

fn is_number(text: &str) -> bool {
    text.parse::<u32>().is_ok()
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace()
        .map(|word| word.parse().expect("a number"))
        .collect()
}
