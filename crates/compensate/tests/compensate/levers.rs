//! Angles times levers: the models of the control read the products of tables back.

use trueaxis_compensate::{Error, Export, ExportedFile, Format, Request};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_predict::CalibratedMachine;

use crate::controllers::{Control, Products, sinumerik};
use crate::export::{error, largest};
use crate::{
    FIVE_AXES, TABLE, THREE_AXES, calibrated, export, poses, request, request_of, scenario,
};

fn with_levers(machine: &CalibratedMachine) -> Request<'_> {
    Request {
        levers: true,
        ..request(machine)
    }
}

fn made(request: &Request<'_>) -> Export {
    export(Format::Sinumerik, request).unwrap()
}

fn control(export: &Export, machine: &CalibratedMachine, products: Products) -> Control {
    sinumerik(export, machine.machine(), products)
}

/// On a control as in the manual's example the products leave what was announced: next to nothing but the interpolation, of what
/// the tables of the lines alone leave tens of µm. Whether the tables of the angles act by themselves makes no difference; with
/// the other sign, the error is larger than without products.
#[test]
fn levers_take_away_what_lines_cannot() {
    let machine = calibrated(&scenario(THREE_AXES), false);
    let (plain, levers) = (made(&request(&machine)), made(&with_levers(&machine)));
    let lines = largest(&machine, &control(&plain, &machine, Products::Alone));
    let with = |products| largest(&machine, &control(&levers, &machine, products));
    let announced = levers.announcement.after;
    println!(
        "lines {:.2}; announced {announced:?}; found {:.2}; angles act {:.2}; other sign {:.2}; no products {:.2} µm",
        lines / MICROMETRE,
        with(Products::Alone) / MICROMETRE,
        with(Products::WithFactor) / MICROMETRE,
        with(Products::OtherSign) / MICROMETRE,
        with(Products::None) / MICROMETRE,
    );
    assert!((with(Products::Alone) - announced.max_mm).abs() < 0.02 * MICROMETRE);
    assert!(announced.max_mm < 0.1 * lines, "{announced:?}");
    assert!(announced.max_mm < 1.5 * MICROMETRE, "{announced:?}");
    assert!(levers.announcement.before == plain.announcement.before);
    assert!((with(Products::WithFactor) - announced.max_mm).abs() < 0.5 * MICROMETRE);
    assert!(with(Products::OtherSign) > 1.5 * lines);
    assert!((with(Products::None) - lines).abs() < 0.02 * MICROMETRE);
    // Which is why the trial comes first.
    assert!(with(Products::WithBoth) > 100.0);
}

/// Nothing changes at home and on the lines through it, and the linear axes gain as much if rotary ones stand at home.
#[test]
fn levers_leave_the_lines_alone() {
    for text in [THREE_AXES, FIVE_AXES] {
        let machine = calibrated(&scenario(text), false);
        let (plain, levers) = (made(&request(&machine)), made(&with_levers(&machine)));
        println!(
            "{}: lines {:?}; levers {:?}",
            machine.name, plain.announcement.after, levers.announcement.after
        );
        assert_eq!(plain.announcement.lines, levers.announcement.lines);
        let [plain, levers] = [&plain, &levers].map(|e| control(e, &machine, Products::Alone));
        let corners = |control: &Control| {
            let corner = |k: usize| {
                let mut commanded = vec![0.0; machine.machine().axes().len()];
                for (axis, bit) in [1, 2, 4].into_iter().enumerate() {
                    commanded[axis] = if k & bit == 0 { 100.0 } else { 390.0 };
                }
                error(&machine, &machine, control, &commanded).norm()
            };
            (0..8).map(corner).fold(0.0, f64::max) / MICROMETRE
        };
        let (of_lines, of_levers) = (corners(&plain), corners(&levers));
        println!("corners: lines {of_lines:.2}, levers {of_levers:.2} µm");
        assert!(of_levers < 0.1 * of_lines);
        for axis in 0..machine.machine().axes().len() {
            for position in [0.0, 1.0, 2.5] {
                let mut commanded = vec![0.0; machine.machine().axes().len()];
                commanded[axis] = position * if axis < 3 { 100.0 } else { 0.5 };
                let pairs = plain(&commanded).into_iter().zip(levers(&commanded));
                let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 1e-6 * MICROMETRE, "{axis} {position}: {off:e}");
            }
        }
    }
}

/// What is there already stays, but where the new products take the angle of the same axis away by the same lever: no target saw
/// what the old one did, and the calibration has the whole angle.
#[test]
fn old_products_are_contained_in_the_new_ones() {
    let machine = calibrated(&scenario(THREE_AXES), false);
    let levers = made(&with_levers(&machine));
    let tables = |export: &Export| {
        let file = export.files.iter().find(|file| file.name == "NC_CEC.INI");
        let names = file.unwrap().text.lines();
        names
            .filter(|line| line.starts_with("$AN_CEC_STEP"))
            .count()
    };
    let foreign = "$AN_CEC[0,0]=0.0\n$AN_CEC[0,1]=0.0001\n$AN_CEC_INPUT_AXIS[0]=(AX1)\n$AN_CEC_OUTPUT_AXIS[0]=(AX1)\n\
                   $AN_CEC_STEP[0]=440\n$AN_CEC_MIN[0]=0\n$AN_CEC_MAX[0]=440\n$AN_CEC_MULT_BY_TABLE[0]=2\n\
                   $AN_CEC[1,0]=-10\n$AN_CEC[1,1]=390\n$AN_CEC_INPUT_AXIS[1]=(AX3)\n$AN_CEC_OUTPUT_AXIS[1]=(AX1)\n\
                   $AN_CEC_STEP[1]=400\n$AN_CEC_MIN[1]=0\n$AN_CEC_MAX[1]=400\n";
    let file = |text: &str| ExportedFile {
        name: "NC_CEC.INI".to_owned(),
        text: text.to_owned(),
    };
    let own: Vec<ExportedFile> = levers.files[..2].to_vec();
    let plain = made(&request(&machine));
    for (old, is_own) in [(own, true), (vec![file(foreign)], false)] {
        for asked in [true, false] {
            let alone = Request {
                levers: asked,
                ..request(&machine)
            };
            let onto = Request {
                onto: &old,
                ..alone
            };
            if asked && !is_own {
                let refused = export(Format::Sinumerik, &onto).unwrap_err().to_string();
                // 10 mm at home, times 0.0001.
                assert!(refused.contains("one reaches 0.0010 mm"), "{refused}");
                continue;
            }
            let (new, sum) = (made(&alone), made(&onto));
            let old_alone = match asked {
                true => plain.clone(),
                false => Export {
                    files: old.clone(),
                    ..levers.clone()
                },
            };
            if is_own {
                // As many as with levers: no table twice.
                assert_eq!(tables(&sum), tables(&levers));
            } else {
                assert_eq!(tables(&sum), tables(&new) + 2);
            }
            for products in [Products::Alone, Products::WithFactor] {
                let [old, new, sum] =
                    [&old_alone, &new, &sum].map(|e| control(e, &machine, products));
                for commanded in poses(&machine, 50) {
                    let [old, new, sum] = [&old, &new, &sum].map(|control| control(&commanded));
                    for ((old, new), sum) in old.iter().zip(&new).zip(&sum) {
                        let off = (old + new - sum).abs();
                        assert!(off < 4e-4 * MICROMETRE, "{is_own} {asked}: {off:e}");
                    }
                }
            }
        }
    }
    // Refused with their place.
    for (from, to, says) in [
        (
            "BY_TABLE[0]=2",
            "BY_TABLE[0]=7",
            "in this file that is not multiplied itself",
        ),
        (
            "BY_TABLE[0]=2",
            "BY_TABLE[0]=1",
            "in this file that is not multiplied itself",
        ),
        (
            "BY_TABLE[0]=2",
            "BY_TABLE[0]=-1",
            "the number of a table from 1, or 0",
        ),
        (
            "$AN_CEC[1,1]=390",
            "$AN_CEC[1,1]=390000",
            "the product an error of a machine",
        ),
        ("$AN_CEC[1,1]=390\n", "", "a value for each point"),
    ] {
        let old = [file(&foreign.replace(from, to))];
        let request = Request {
            onto: &old,
            ..request(&machine)
        };
        let said = export(Format::Sinumerik, &request).unwrap_err().to_string();
        assert!(said.contains(says), "{said}\n  expected {says}");
    }
}

/// The trial tells the kinds of controls apart as it says.
#[test]
fn the_trial_tells_what_the_control_does() {
    let machine = calibrated(&scenario(THREE_AXES), false);
    let export = made(&with_levers(&machine));
    let trial = export
        .files
        .iter()
        .find(|file| file.name == "LEVER_TRIAL.INI");
    let text = &trial.unwrap().text;
    println!("{text}");
    let alone = Export {
        files: vec![ExportedFile {
            name: "NC_CEC.INI".to_owned(),
            text: text.clone(),
        }],
        ..export.clone()
    };
    // The first product: an angle of X times the position of Y, 400 mm at its end, for X.
    for part in [
        "Y = 400: X changes by -0.04 mm more",
        "By -0.44 mm more",
        "By 0.04 mm more",
    ] {
        assert!(text.contains(part), "{text}");
    }
    for (products, at_home, more) in [
        (Products::Alone, 0.0, -0.04),
        (Products::WithFactor, -0.1, -0.04),
        (Products::WithBoth, -0.1, -0.44),
        (Products::OtherSign, 0.0, 0.04),
        (Products::None, 0.0, 0.0),
    ] {
        let control = control(&alone, &machine, products);
        let x = |y: f64| control(&[0.0, y, 0.0])[0];
        assert!((x(0.0) - at_home).abs() < 1e-9, "{products:?}");
        assert!((x(400.0) - x(0.0) - more).abs() < 1e-9, "{products:?}");
    }
}

#[test]
fn levers_that_cannot_be_made_are_refused() {
    let machine = calibrated(&scenario(THREE_AXES), false);
    for format in Format::ALL {
        if format != Format::Sinumerik {
            let asked = Request {
                levers: true,
                ..request_of(format, &machine)
            };
            let said = export(format, &asked).unwrap_err().to_string();
            assert!(
                said.contains("takes no levers; only sinumerik multiplies tables"),
                "{said}"
            );
        }
    }
    // The last axis before the tool: no other one moves on its angle.
    let last = Request {
        axis: Some(2),
        ..with_levers(&machine)
    };
    let table = calibrated(&scenario(TABLE), false);
    for request in [last, with_levers(&table)] {
        let said = export(Format::Sinumerik, &request).unwrap_err().to_string();
        assert!(said.contains("these axes have none"), "{said}");
    }
    // 31 levers of their own, two tables each, beside the six of the lines.
    let table = |index: usize, input: &str, length: usize, value: f64, multiplied_by: usize| {
        format!(
            "$AN_CEC[{index},0]=0\n$AN_CEC[{index},1]={value}\n$AN_CEC_INPUT_AXIS[{index}]=({input})\n\
             $AN_CEC_OUTPUT_AXIS[{index}]=(AX2)\n$AN_CEC_STEP[{index}]={length}\n$AN_CEC_MIN[{index}]=0\n\
             $AN_CEC_MAX[{index}]={length}\n$AN_CEC_MULT_BY_TABLE[{index}]={multiplied_by}\n"
        )
    };
    let product = |k: usize| {
        let factor = table(2 * k, "AX1", 440, 1e-6, 2 * k + 2);
        factor + &table(2 * k + 1, "AX3", 300 + k, 300.0, 0)
    };
    let old = [ExportedFile {
        name: "NC_CEC.INI".to_owned(),
        text: (0..31).map(product).collect(),
    }];
    let many = Request {
        onto: &old,
        ..request(&machine)
    };
    let said = export(Format::Sinumerik, &many).unwrap_err().to_string();
    assert!(
        said.contains("at most 62 sag compensation tables; these are 68"),
        "{said}"
    );
}

/// Points that no control holds, without an old table, too.
#[test]
fn too_many_points_are_refused() {
    let machine = calibrated(&scenario(THREE_AXES), false);
    for levers in [false, true] {
        let fine = Request {
            step: Some(0.05),
            axis: Some(0),
            levers,
            ..request(&machine)
        };
        let refused = export(Format::Sinumerik, &fine).unwrap_err();
        let is_expected = matches!(
            refused,
            Error::TooManyPoints {
                points: 8801,
                most: 5000,
                ..
            }
        );
        assert!(is_expected, "{refused}");
    }
}
