//! Small models of what controls make of their files, written from their descriptions: what they add to the commanded
//! positions (mm, rad; axes X, Y, Z first).

mod sinumerik;

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3, Vector6};
use trueaxis_compensate::{Export, Format, TableSign};
use trueaxis_kinematics::{
    AxisKind, Branch, GeometricErrors, Ideal, LocationComponent, LocationError, Machine,
    MotionError,
};

pub(crate) use sinumerik::{Products, sinumerik};

/// What a control adds.
pub(crate) type Control = Box<dyn Fn(&[f64]) -> Vec<f64>>;

pub(crate) fn control(
    format: Format,
    export: &Export,
    machine: &Machine,
    tool: Point3<f64>,
) -> Control {
    let text = |name: &str| {
        let file = export.files.iter().find(|file| file.name == name);
        file.map(|file| file.text.clone())
    };
    match format {
        Format::Grid => grid(&text("grid.csv").unwrap(), machine),
        Format::LinuxCnc => linuxcnc(export, machine),
        Format::Isg => {
            let errors = isg(&text("volcomp.csv").unwrap(), machine);
            let tool = ["P0X", "P0Y", "P0Z"].map(|name| errors.locations[name]);
            with_errors(errors, machine, tool.into())
        }
        Format::Etalon => with_errors(etalon(&text("etalon.txt").unwrap(), machine), machine, tool),
        Format::Sinumerik => sinumerik(export, machine, Products::Alone),
        Format::Heidenhain => heidenhain(export, machine, TableSign::Error),
        Format::Marlin => marlin(&text("skew.gcode").unwrap()),
        Format::Klipper => klipper(&text("skew.gcode").unwrap()),
    }
}

/// Linear, constant outside.
fn linear(points: &[(f64, f64)], x: f64) -> f64 {
    if x <= points[0].0 {
        return points[0].1;
    }
    for pair in points.windows(2) {
        let [(a, fa), (b, fb)] = [pair[0], pair[1]];
        if x <= b {
            return fa + (fb - fa) * (x - a) / (b - a);
        }
    }
    points[points.len() - 1].1
}

fn numbers(line: &str, separator: char) -> Vec<f64> {
    let cells = line.split(separator).filter(|cell| !cell.is_empty());
    cells.map(|cell| cell.trim().parse().unwrap()).collect()
}

fn is_rotary(machine: &Machine, axis: usize) -> bool {
    machine.axes()[axis].kind() == AxisKind::Rotary
}

fn in_file(machine: &Machine, axis: usize, value: f64) -> f64 {
    if is_rotary(machine, axis) {
        value.to_degrees()
    } else {
        value
    }
}

fn from_file(machine: &Machine, axis: usize, value: f64) -> f64 {
    if is_rotary(machine, axis) {
        value.to_radians()
    } else {
        value
    }
}

/// Trilinear over X, Y, Z, from the columns `add_`.
fn grid(text: &str, machine: &Machine) -> Control {
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| numbers(line, ','))
        .collect();
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    assert_eq!(header[..3], ["X", "Y", "Z"]);
    assert_eq!(header[9..], ["add_X_um", "add_Y_um", "add_Z_um"]);
    let axes = machine.axes().len();
    let key = |row: &[f64]| [0, 1, 2].map(|c: usize| row[c].to_bits());
    let values: BTreeMap<[u64; 3], Vec<f64>> = rows
        .iter()
        .map(|row| (key(row), row[9..].to_vec()))
        .collect();
    let mut nodes: [Vec<f64>; 3] = [const { Vec::new() }; 3];
    for row in &rows {
        for (c, nodes) in nodes.iter_mut().enumerate() {
            if !nodes.contains(&row[c]) {
                nodes.push(row[c]);
            }
        }
    }
    Box::new(move |q| {
        let corner = |c: usize| {
            let above = nodes[c]
                .iter()
                .position(|&node| node >= q[c])
                .unwrap_or(nodes[c].len() - 1)
                .max(1);
            let (a, b) = (nodes[c][above - 1], nodes[c][above]);
            [(a, (b - q[c]) / (b - a)), (b, (q[c] - a) / (b - a))]
        };
        let mut added = vec![0.0; axes];
        for (x, wx) in corner(0) {
            for (y, wy) in corner(1) {
                for (z, wz) in corner(2) {
                    let value = &values[&key(&[x, y, z])];
                    (0..3).for_each(|c| added[c] += wx * wy * wz * value[c] * 1e-3);
                }
            }
        }
        added
    })
}

/// `joint = C axis`, then `nominal - actual` at the joint's position: the mean of both directions.
fn linuxcnc(export: &Export, machine: &Machine) -> Control {
    let axes = machine.axes().len();
    let mut tables: Vec<Option<Vec<(f64, f64)>>> = vec![None; axes];
    let mut matrix = BTreeMap::new();
    for file in &export.files {
        if let Some(name) = file.name.strip_suffix(".comp") {
            let axis = machine.axis_index(name).unwrap();
            // The reader: three numbers or the end.
            let lines = file.text.lines().map(|line| numbers(line, ' '));
            let lines: Vec<Vec<f64>> = lines.take_while(|line| line.len() == 3).collect();
            assert_eq!(lines.len(), file.text.lines().count());
            let triplet = |l: &Vec<f64>| {
                let added = l[0] - 0.5 * (l[1] + l[2]);
                (l[0], from_file(machine, axis, added))
            };
            tables[axis] = Some(lines.iter().map(triplet).collect());
        } else {
            for line in file.text.lines() {
                if let Some(rest) = line.strip_prefix("setp matrixkins.C_") {
                    let (name, value) = rest.split_once(' ').unwrap();
                    matrix.insert(name.to_owned(), value.parse::<f64>().unwrap());
                }
            }
        }
    }
    let machine = machine.clone();
    Box::new(move |q| {
        let mut joints = q.to_vec();
        if !matrix.is_empty() {
            for (row, joint) in joints.iter_mut().take(3).enumerate() {
                let letters = ["x", "y", "z"];
                let c = |column: usize| matrix[&format!("{}{}", letters[row], letters[column])];
                *joint = (0..3).map(|column| c(column) * q[column]).sum();
            }
        }
        let motor = joints.iter().enumerate().map(|(axis, &joint)| {
            let table = tables[axis].as_ref();
            joint + table.map_or(0.0, |table| linear(table, in_file(&machine, axis, joint)))
        });
        motor.zip(q).map(|(motor, q)| motor - q).collect()
    })
}

/// The active line of the `.CMA` says which `.COM` goes by the position of which axis; its columns are for the axes of their
/// names, the own one with `BACKLASH` for the other direction: the mean of both. A control of either sign.
pub(crate) fn heidenhain(export: &Export, machine: &Machine, sign: TableSign) -> Control {
    let lines = |name: &str| {
        let file = export.files.iter().find(|file| file.name == name).unwrap();
        let lines = file
            .text
            .lines()
            .map(|line| line.split(',').map(str::to_owned).collect());
        lines.collect::<Vec<Vec<String>>>()
    };
    let cma = lines("config.cma.csv");
    assert_eq!((cma[0][0].as_str(), cma[1][0].as_str()), ("ACTIVE", "*"));
    // By the position of an axis, for an axis, at points.
    let mut tables = Vec::new();
    for (axis, file) in cma[0].iter().zip(&cma[1]).skip(1) {
        let com = lines(&format!("{file}.csv"));
        let cell = |row: &[String], c: usize| row[c].parse::<f64>().unwrap();
        let backlash = com[0].iter().position(|name| name == "BACKLASH");
        for (c, name) in com[0]
            .iter()
            .enumerate()
            .skip(1)
            .filter(|(_, name)| *name != "BACKLASH")
        {
            let other = backlash.filter(|_| name == axis).unwrap_or(c);
            let points = com[1..].iter();
            let points = points.map(|row| (cell(row, 0), 0.5 * (cell(row, c) + cell(row, other))));
            let [input, output] = [axis, name].map(|name| machine.axis_index(name).unwrap());
            tables.push((input, output, points.collect::<Vec<_>>()));
        }
    }
    Box::new(move |q| {
        let mut added = vec![0.0; q.len()];
        for (input, output, points) in &tables {
            let value = linear(points, q[*input]);
            added[*output] += match sign {
                TableSign::Error => -value,
                TableSign::Correction => value,
            };
        }
        added
    })
}

/// `x - y I - z (J - I K)`, `y - z K`.
fn marlin(text: &str) -> Control {
    let line = text.lines().find(|line| line.starts_with("M852")).unwrap();
    let words: BTreeMap<char, f64> = line
        .split(' ')
        .skip(1)
        .map(|word| (word.chars().next().unwrap(), word[1..].parse().unwrap()))
        .collect();
    skew([words[&'I'], words[&'J'], words[&'K']])
}

fn skew([xy, xz, yz]: [f64; 3]) -> Control {
    Box::new(move |q| {
        let x = q[0] - q[1] * xy - q[2] * (xz - xy * yz);
        let y = q[1] - q[2] * yz;
        let mut added = vec![0.0; q.len()];
        (added[0], added[1]) = (x - q[0], y - q[1]);
        added
    })
}

/// The angle at A from the diagonals AC, BD and the side AD of a parallelogram.
fn klipper(text: &str) -> Control {
    let line = text
        .lines()
        .find(|line| line.starts_with("SET_SKEW"))
        .unwrap();
    let factor = |plane: &str| {
        let word = line
            .split(' ')
            .find_map(|word| word.strip_prefix(plane))
            .unwrap();
        let lengths = numbers(word, ',');
        let [ac, bd, ad] = [lengths[0], lengths[1], lengths[2]];
        let side = (2.0 * ac * ac + 2.0 * bd * bd - 4.0 * ad * ad).sqrt() / 2.0;
        let angle = ((ac * ac - side * side - ad * ad) / (2.0 * side * ad)).acos();
        (std::f64::consts::FRAC_PI_2 - angle).tan()
    };
    skew(["XY=", "XZ=", "YZ="].map(factor))
}

/// The control without `alternative_model 1`: a rotary axis turns about where it should be, and its location error acts as its
/// component errors do.
pub(crate) fn isg_by_default(text: &str, machine: &Machine, tool: Point3<f64>) -> Control {
    let mut errors = isg(text, machine);
    errors.turns_about_nominal = true;
    with_errors(errors, machine, tool)
}

/// The errors that a file holds.
pub(crate) struct Errors {
    /// For each axis and component points, mm or rad.
    curves: BTreeMap<String, Vec<(f64, f64)>>,
    locations: BTreeMap<String, f64>,
    machine: Machine,
    turns_about_nominal: bool,
}

/// Columns by name; blocks between `#`.
pub(crate) fn isg(text: &str, machine: &Machine) -> Errors {
    let mut errors = Errors {
        curves: BTreeMap::new(),
        locations: BTreeMap::new(),
        machine: machine.clone(),
        turns_about_nominal: false,
    };
    let lines = text.lines().filter(|line| !line.starts_with("//"));
    let lines: Vec<&str> = lines.collect();
    for block in lines.split(|line| line.starts_with('#')) {
        let header: Vec<&str> = block[0].split(' ').collect();
        for row in &block[1..] {
            let values = numbers(row, ' ');
            if header[0].len() == 1 {
                for (name, value) in header[1..].iter().zip(&values[1..]) {
                    errors
                        .curves
                        .entry((*name).to_owned())
                        .or_default()
                        .push((values[0], *value));
                }
            } else {
                let named = header.iter().zip(values);
                errors
                    .locations
                    .extend(named.map(|(name, value)| ((*name).to_owned(), value)));
            }
        }
    }
    errors
}

pub(crate) fn etalon(text: &str, machine: &Machine) -> Errors {
    let mut errors = Errors {
        curves: BTreeMap::new(),
        locations: BTreeMap::new(),
        machine: machine.clone(),
        turns_about_nominal: false,
    };
    let mut name = String::new();
    for line in text
        .lines()
        .map(|line| line.split("//").next().unwrap().trim())
    {
        if let Some(section) = line.strip_prefix('[') {
            name = section.trim_end_matches(']').to_owned();
        } else if let Some(value) = line.strip_prefix("VALUE = ") {
            errors
                .locations
                .insert(name.clone(), value.parse().unwrap());
        } else if !line.is_empty() && !line.contains(['{', '}']) {
            let pair = numbers(line, ' ');
            errors
                .curves
                .entry(name.clone())
                .or_default()
                .push((pair[0], pair[1]));
        }
    }
    errors
}

impl Errors {
    fn in_file(&self, axis: usize) -> LocationError {
        let mut location = LocationError::default();
        let name = self.machine.axes()[axis].name();
        for i in 0..3 {
            for component in [LocationComponent::Offset(i), LocationComponent::Tilt(i)] {
                let value = self.locations.get(&component.name(name));
                *component.of_mut(&mut location) = value.copied().unwrap_or_default();
            }
        }
        location
    }

    fn is_part_of_the_motion(&self, axis: usize) -> bool {
        self.turns_about_nominal && is_rotary(&self.machine, axis)
    }
}

impl GeometricErrors for Errors {
    fn location(&self, axis: usize) -> LocationError {
        match self.is_part_of_the_motion(axis) {
            true => LocationError::default(),
            false => self.in_file(axis),
        }
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        let name = self.machine.axes()[axis].name();
        let of = |c: usize| {
            let curve = self
                .curves
                .get(&format!("E{}{name}", ["X", "Y", "Z", "A", "B", "C"][c]));
            curve.map_or(0.0, |curve| {
                linear(curve, in_file(&self.machine, axis, position))
            })
        };
        let motion = MotionError::from_vector(&Vector6::from_fn(|c, _| of(c)));
        if !self.is_part_of_the_motion(axis) {
            return motion;
        }
        let LocationError {
            offset_mm,
            tilt_rad,
        } = self.in_file(axis);
        MotionError::new(
            motion.translation_mm + offset_mm,
            motion.rotation_rad + tilt_rad,
        )
    }
}

/// The tool point goes back by its error, seen from the bed.
fn with_errors(errors: Errors, machine: &Machine, tool: Point3<f64>) -> Control {
    // δ of linear axes is at the origin.
    let machine = machine.with_axes(|_, axis| match axis.kind() {
        AxisKind::Linear => axis.with_reference(Point3::origin()),
        AxisKind::Rotary => axis,
    });
    Box::new(move |q| {
        let e = machine.tool_error(&errors, q, tool).translation_mm;
        let workpiece = machine.chain_motion(&Ideal, machine.branch(Branch::Workpiece), q);
        let back: Vector3<f64> = -(workpiece.rotation * e);
        let mut added = vec![0.0; q.len()];
        (0..3).for_each(|c| added[c] = back[c]);
        added
    })
}
