//! Small correct campaigns as text, with exact lengths, and ways to damage them.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;

use trueaxis_campaign::{Campaign, Error, read};

/// The files of a campaign by name.
#[derive(Clone)]
pub(crate) struct Files(pub(crate) BTreeMap<String, String>);

pub(crate) const STATIONS: [(&str, [f64; 3]); 4] = [
    ("S1", [1500.0, -800.0, 300.0]),
    ("S2", [-900.0, -600.0, 200.0]),
    ("S3", [300.0, 1900.0, 250.0]),
    ("S4", [400.0, 300.0, 2000.0]),
];

const DEAD_PATHS: [f64; 4] = [1234.5678, 987.6543, 1500.25, 1111.1111];

const TOOL_TARGETS: [(&str, [f64; 3]); 3] = [
    ("P", [16.338, 452.716, 122.416]),
    ("Q", [157.086, 332.593, 324.879]),
    ("K", [248.925, 603.055, 412.448]),
];

const TABLE_TARGETS: [(&str, [f64; 3]); 3] = [
    ("P", [-105.805, 135.341, 0.0]),
    ("Q", [128.851, 87.816, 39.98]),
    ("K", [24.903, -110.858, 15.266]),
];

/// Three linear axes, four stations, three targets on the tool; forward and backward. Lines 2, 3, 4
/// of `lengths.csv` are P, Q, K at home from S1, lines 5, 6, 7 the same at X = 100.
pub(crate) fn three_axes() -> Files {
    let json = campaign_json(
        r#""tool": ["X", "Y", "Z"], "workpiece": []"#,
        r#"{ "name": "X", "kind": "linear", "direction": [1, 0, 0], "travel": [0, 440] },
      { "name": "Y", "kind": "linear", "direction": [0, 1, 0], "travel": [0, 400] },
      { "name": "Z", "kind": "linear", "direction": [0, 0, 1], "travel": [0, 400] }"#,
        &TOOL_TARGETS,
        "Z",
        r#"{ "name": "x", "axis": "X" }, { "name": "y", "axis": "Y" }, { "name": "z", "axis": "Z" }"#,
        r#""lengths": "lengths.csv",
  "verification": [
    { "name": "LI along X", "kind": "positioning", "axis": "X", "target_mm": [175.6, 497.5, 312.1], "readings": "li_x.csv" }
  ]"#,
    );
    let mut csv = String::from("time_s,station,repeat,run,direction,X,Y,Z,target,length_mm\n");
    let mut time_s = 0.0;
    for (station, dead_path) in STATIONS.iter().zip(DEAD_PATHS) {
        for (axis, run) in ["x", "y", "z"].iter().enumerate() {
            let there = (0..5).map(|i| (1, f64::from(i) * 100.0));
            let back = (0..5).rev().map(|i| (-1, f64::from(i) * 100.0));
            for (direction, q) in there.chain(back) {
                let mut positions = [0.0; 3];
                positions[axis] = q;
                for (target, home) in TOOL_TARGETS {
                    let point = [0, 1, 2].map(|i| home[i] + positions[i]);
                    let length = on_grid(distance(point, station.1) - dead_path);
                    let [x, y, z] = positions;
                    let name = station.0;
                    writeln!(
                        csv,
                        "{time_s},{name},1,{run},{direction},{x},{y},{z},{target},{length}"
                    )
                    .unwrap();
                    time_s += 2.5;
                }
            }
        }
    }
    let mut li_x = String::from("cycle,direction,X,Y,Z,deviation_um\n");
    for i in 0..5 {
        writeln!(li_x, "1,1,{},0,0,{}", i * 100, f64::from(i) * 0.75).unwrap();
    }
    Files(BTreeMap::from([
        ("campaign.json".to_owned(), json),
        ("lengths.csv".to_owned(), csv),
        ("li_x.csv".to_owned(), li_x),
    ]))
}

/// A rotary table, four stations, three targets on it; lines as in [`three_axes`], 22.5° steps.
pub(crate) fn rotary_table() -> Files {
    let mut files = table_files(r#""lengths": "lengths.csv","#);
    let mut csv = String::from("time_s,station,repeat,run,direction,C,target,length_mm\n");
    let mut time_s = 0.0;
    for (station, dead_path) in STATIONS.iter().zip(DEAD_PATHS) {
        for i in 0..=16 {
            let degrees = f64::from(i) * 22.5;
            for (target, home) in TABLE_TARGETS {
                let length = on_grid(distance(turned(home, degrees), station.1) - dead_path);
                let name = station.0;
                writeln!(csv, "{time_s},{name},1,c,1,{degrees},{target},{length}").unwrap();
                time_s += 2.5;
            }
        }
    }
    files.0.insert("lengths.csv".to_owned(), csv);
    files
}

/// The same table measured as points, in the frame of an instrument that stands elsewhere.
pub(crate) fn table_points() -> Files {
    let mut files = table_files(r#""points": "points.csv","#);
    let mut csv = String::from("time_s,repeat,run,direction,C,target,x_mm,y_mm,z_mm,sigma_um\n");
    for i in 0..=16 {
        let degrees = f64::from(i) * 22.5;
        for (target, home) in TABLE_TARGETS {
            // Another rigid frame: axes exchanged, origin shifted.
            let [x, y, z] = turned(home, degrees);
            let (a, b, c) = (1000.0 + y, 200.0 + z, x - 300.0);
            let time_s = i * 30;
            writeln!(
                csv,
                "{time_s},1,c,1,{degrees},{target},{a:.4},{b:.4},{c:.4},15"
            )
            .unwrap();
        }
    }
    files.0.insert("points.csv".to_owned(), csv);
    files
}

fn table_files(data: &str) -> Files {
    let json = campaign_json(
        r#""tool": [], "workpiece": ["C"]"#,
        r#"{ "name": "C", "kind": "rotary", "direction": [0, 0, 1], "travel": [0, 360], "position_mm": [0, 0, 0] }"#,
        &TABLE_TARGETS,
        "C",
        r#"{ "name": "c", "axis": "C" }"#,
        &format!(
            r#"{data}
  "verification": [
    {{ "name": "DBB at A", "kind": "ballbar", "ball_mm": [121.779, 87.578, 59.216], "ball_carried_by": "C", "center_mm": [0, 0, 59.2], "readings": "dbb_a.csv" }}
  ]"#
        ),
    );
    let mut dbb = String::from("time_s,cycle,direction,C,delta_um\n");
    for i in 0..5 {
        writeln!(dbb, "{},1,-1,{},{}", i * 10, i * 90, 0.5 * f64::from(i)).unwrap();
    }
    Files(BTreeMap::from([
        ("campaign.json".to_owned(), json),
        ("dbb_a.csv".to_owned(), dbb),
    ]))
}

fn campaign_json(
    branches: &str,
    axes: &str,
    targets: &[(&str, [f64; 3])],
    carrier: &str,
    runs: &str,
    data: &str,
) -> String {
    let list = |entries: Vec<String>| entries.join(",\n    ");
    let target = |(name, [x, y, z]): &(&str, [f64; 3])| {
        format!(
            r#"{{ "name": "{name}", "position_mm": [{x}, {y}, {z}], "carried_by": "{carrier}" }}"#
        )
    };
    let station = |(name, [x, y, z]): &(&str, [f64; 3])| {
        format!(r#"{{ "name": "{name}", "approx_mm": [{x}, {y}, {z}] }}"#)
    };
    let targets = list(targets.iter().map(target).collect());
    let stations = list(STATIONS.iter().map(station).collect());
    format!(
        r#"{{
  "format": "trueaxis-campaign",
  "version": 1,
  "name": "test",
  "machine": {{
    "name": "machine",
    "kinematics": {{ {branches} }},
    "axes": [
      {axes}
    ]
  }},
  "instrument": {{ "name": "laser tracker", "length_sigma_um": 0.269, "length_sigma_ppm": 0.0, "repeatability_um": 1.0 }},
  "targets": [
    {targets}
  ],
  "stations": [
    {stations}
  ],
  "runs": [ {runs} ],
  {data}
}}
"#
    )
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

/// Lengths have seven decimals.
fn on_grid(length: f64) -> f64 {
    (length * 1e7).round() / 1e7
}

fn turned([x, y, z]: [f64; 3], degrees: f64) -> [f64; 3] {
    let (s, c) = degrees.to_radians().sin_cos();
    [x * c - y * s, x * s + y * c, z]
}

impl Files {
    /// Writes the files to a folder of their own and reads the campaign.
    pub(crate) fn read(&self) -> Result<Campaign, Error> {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in &self.0 {
            fs::write(folder.path().join(name), text).unwrap();
        }
        read(&folder.path().join("campaign.json"))
    }

    /// Replaces `from`, which must be there exactly once.
    pub(crate) fn replace(&mut self, file: &str, from: &str, to: &str) {
        let text = self.0.get_mut(file).unwrap();
        assert_eq!(text.matches(from).count(), 1, "{from} in {file}");
        *text = text.replace(from, to);
    }

    /// Replaces `from` in `campaign.json`.
    pub(crate) fn json(&mut self, from: &str, to: &str) {
        self.replace("campaign.json", from, to);
    }

    /// Lets `change` work on all lines of a file.
    pub(crate) fn lines(&mut self, file: &str, change: impl Fn(&mut Vec<String>)) {
        let text = self.0.get_mut(file).unwrap();
        let mut lines = text.lines().map(str::to_owned).collect();
        change(&mut lines);
        *text = lines.join("\n") + "\n";
    }

    /// Lets `change` work on the cells of a column, given the fields of its row by name.
    pub(crate) fn column(
        &mut self,
        file: &str,
        column: &str,
        change: impl Fn(&str, &BTreeMap<&str, &str>) -> String,
    ) {
        let text = self.0.get_mut(file).unwrap();
        let mut lines = text.lines();
        let header: Vec<&str> = lines.next().unwrap().split(',').collect();
        let index = header.iter().position(|&c| c == column).unwrap();
        let mut changed = vec![header.join(",")];
        for line in lines {
            let cells: Vec<&str> = line.split(',').collect();
            let row = BTreeMap::from_iter(header.iter().copied().zip(cells.iter().copied()));
            let mut new: Vec<String> = cells.iter().map(|&c| c.to_owned()).collect();
            new[index] = change(cells[index], &row);
            changed.push(new.join(","));
        }
        *text = changed.join("\n") + "\n";
    }

    /// Multiplies a column by a factor.
    pub(crate) fn scale(&mut self, file: &str, column: &str, factor: f64) {
        self.column(file, column, |cell, _| {
            (cell.parse::<f64>().unwrap() * factor).to_string()
        });
    }

    /// Puts `text` into the cell of a line (from 1) and column.
    pub(crate) fn cell(&mut self, file: &str, line: usize, column: &str, text: &str) {
        let header = self.0[file].lines().next().unwrap().to_owned();
        let index = header.split(',').position(|c| c == column).unwrap();
        self.lines(file, |lines| {
            let mut cells: Vec<&str> = lines[line - 1].split(',').collect();
            cells[index] = text;
            lines[line - 1] = cells.join(",");
        });
    }
}

/// A damage, and what its message must say: parts of it, with ` … ` between them.
pub(crate) type Case = (fn(&mut Files), &'static str);

/// Damages the campaign in each way alone and compares the messages.
pub(crate) fn assert_refused(campaign: &Files, cases: &[Case]) {
    campaign.read().unwrap();
    for (damage, says) in cases {
        let mut files = campaign.clone();
        damage(&mut files);
        let message = match files.read() {
            Ok(_) => panic!("was accepted: {says}"),
            Err(error) => error.to_string(),
        };
        for part in says.split(" … ") {
            assert!(message.contains(part), "no `{part}` in: {message}");
        }
    }
}
