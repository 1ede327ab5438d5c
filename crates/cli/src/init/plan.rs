//! What a starting campaign measures: the rows of its table before anything is measured, and the map of an export.

/// A run with its axis, its targets in the order of reading, and its positions from, to, step.
type Leg = (&'static str, &'static str, [&'static str; 3], [i32; 3]);

/// The machine types.
pub(super) struct Plan {
    /// `campaign.json`, with `NAME` for the name.
    pub(super) campaign: &'static str,
    pub(super) axes: &'static [&'static str],
    pub(super) legs: &'static [Leg],
    /// Whether each run goes back.
    pub(super) back: bool,
}

const PQK: [&str; 3] = ["P", "Q", "K"];
const UVW: [&str; 3] = ["U", "V", "W"];

/// Stations of `lengths.csv`.
const STATIONS: [&str; 4] = ["S1", "S2", "S3", "S4"];

/// How often each station sees the whole path: two tell the machine's repeatability from the laser.
const REPEATS: usize = 2;

pub(super) const FXYZ: Plan = Plan {
    campaign: include_str!("fxyz.json"),
    axes: &["X", "Y", "Z"],
    legs: &[
        ("x", "X", PQK, [0, 440, 20]),
        ("y", "Y", PQK, [0, 400, 20]),
        ("z", "Z", PQK, [0, 400, 20]),
    ],
    back: false,
};

pub(super) const FIVE_AXIS: Plan = Plan {
    campaign: include_str!("five-axis.json"),
    axes: &["X", "Y", "Z", "A", "C"],
    legs: &[
        ("x", "X", PQK, [0, 400, 40]),
        ("y", "Y", PQK, [0, 400, 40]),
        ("z", "Z", PQK, [0, 400, 40]),
        ("a", "A", UVW, [-60, 90, 15]),
        ("c", "C", UVW, [0, 360, 30]),
    ],
    back: true,
};

pub(super) const ROTARY_STAGE: Plan = Plan {
    campaign: include_str!("rotary-stage.json"),
    axes: &["C"],
    legs: &[("c", "C", PQK, [0, 360, 20])],
    back: false,
};

impl Plan {
    /// The table before anything is measured: time and what is measured are empty.
    pub(super) fn table(&self, points: bool) -> String {
        let axes = self.axes.join(",");
        let mut text = match points {
            false => format!("time_s,station,repeat,run,direction,{axes},target,length_mm\n"),
            true => format!("time_s,repeat,run,direction,{axes},target,x_mm,y_mm,z_mm\n"),
        };
        let stations: &[&str] = if points { &[""] } else { &STATIONS };
        for station in stations {
            for repeat in 1..=REPEATS {
                for (&(run, moving, targets, _), position, direction) in self.stops() {
                    let on_axis = |axis: &&str| if *axis == moving { position } else { 0 };
                    let positions = self.axes.iter().map(|axis| on_axis(axis).to_string());
                    let positions = positions.collect::<Vec<_>>().join(",");
                    for target in targets {
                        text += &match points {
                            false => format!(
                                ",{station},{repeat},{run},{direction},{positions},{target},\n"
                            ),
                            true => {
                                format!(",{repeat},{run},{direction},{positions},{target},,,\n")
                            }
                        };
                    }
                }
            }
        }
        text
    }

    /// The stops of one repeat: run, position and direction.
    fn stops(&self) -> Vec<(&Leg, i32, i32)> {
        let mut stops = Vec::new();
        for leg in self.legs {
            let (.., [from, to, step]) = *leg;
            let there: Vec<i32> = (0..=(to - from) / step).map(|i| from + i * step).collect();
            stops.extend(there.iter().map(|&position| (leg, position, 1)));
            if self.back {
                stops.extend(there.iter().rev().map(|&position| (leg, position, -1)));
            }
        }
        stops
    }

    /// A map of an export that this path was measured for.
    pub(super) fn map(&self, points: bool) -> String {
        let measured = match points {
            true => {
                "x_mm = { column = \"X\", unit = \"mm\" }   # or \"in\", \"m\", \"um\"\n\
                 y_mm = { column = \"Y\", unit = \"mm\" }\nz_mm = { column = \"Z\", unit = \"mm\" }\n"
            }
            false => {
                "station = { column = \"Station\" }\n\
                 length_mm = { column = \"Distance\", unit = \"mm\" }   # or \"in\", \"m\", \"um\"\n"
            }
        };
        let axes = self.axes.iter().map(|&axis| {
            let unit = if matches!(axis, "A" | "C") {
                "deg"
            } else {
                "mm"
            };
            format!("{axis} = {{ unit = \"{unit}\" }}\n")
        });
        let legs = self.legs.iter().map(|leg| {
            let (run, axis, [a, b, c], [from, to, step]) = leg;
            let back = if self.back { ", back = true" } else { "" };
            format!(
                "  {{ run = \"{run}\", axis = \"{axis}\", from = {from}, to = {to}, step = {step}{back}, \
                 targets = [\"{a}\", \"{b}\", \"{c}\"] }},\n"
            )
        });
        include_str!("import.toml")
            .replace("KIND", if points { "points" } else { "lengths" })
            .replace("MEASURED\n", measured)
            .replace("AXES\n", &axes.collect::<String>())
            .replace("LEGS\n", &legs.collect::<String>())
    }
}
