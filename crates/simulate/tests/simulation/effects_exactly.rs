//! What each effect does to the lengths, against its formula.

use serde_json::{Value, json};

use crate::by_hand::{
    AIR, NONE, Reading, SPINDLE, UM, assert_formula, of_length, of_station, of_target,
};
use crate::exactness::{ARCSEC, Vector, add, scale, stage_motion, sub};

const PPM: f64 = 1e-6;

fn effect(id: &str, subject: Value, parameters: &[(&str, f64, &str)]) -> Value {
    let parameters = parameters
        .iter()
        .map(|(name, value, unit)| json!({ "name": name, "value": value, "unit": unit }));
    json!({ "effect": id, "subject": subject, "parameters": parameters.collect::<Vec<_>>() })
}

fn vector_effect(id: &str, subject: Value, name: &str, d: Vector, time_s: Option<f64>) -> Value {
    let names = ["x", "y", "z"].map(|axis| format!("{name}_{axis}"));
    let values = names.iter().zip(d);
    let mut parameters: Vec<_> = values.map(|(name, v)| (name.as_str(), v, "um")).collect();
    parameters.extend(time_s.map(|time_s| ("time", time_s, "s")));
    effect(id, subject, &parameters)
}

/// Some micrometres in every direction.
const D_UM: Vector = [4.1, -7.3, 5.6];

fn d_mm() -> Vector {
    scale(D_UM, UM)
}

#[test]
fn instrument() {
    let one = json!({ "station": "S2" });
    assert_formula(
        &effect("dead_path_drift", one.clone(), &[("rate_S2", 6.5, "um")]),
        &|r| of_length(6.5 * UM * r.occupation_progress * Reading::when(r.station == "S2")),
    );
    let rates = [1.5, -2.0, 4.0, 3.0];
    let names = ["rate_S1", "rate_S2", "rate_S3", "rate_S4"];
    let all = [0, 1, 2, 3].map(|i| (names[i], rates[i], "um"));
    assert_formula(&effect("dead_path_drift", json!({}), &all), &|r| {
        let own = names.iter().position(|name| name.ends_with(r.station));
        of_length(rates[own.unwrap()] * UM * r.occupation_progress)
    });
    assert_formula(
        &effect(
            "dead_path_jump",
            one.clone(),
            &[("jump", -3.5, "um"), ("time", 1800.0, "s")],
        ),
        &|r| of_length(-3.5 * UM * Reading::when(r.station == "S2" && r.time_s > 1800.0)),
    );
    assert_formula(
        &effect(
            "refraction_drift",
            json!({}),
            &[("scale_drift", 2.5, "ppm")],
        ),
        &|r| of_length(2.5 * PPM * r.distance_mm() * r.progress),
    );
    assert_formula(
        &effect("length_scale", json!({}), &[("scale", 1.5, "ppm")]),
        &|r| of_length(1.5 * PPM * r.distance_mm()),
    );
    assert_formula(
        &effect("station_scale", one.clone(), &[("scale", -2.0, "ppm")]),
        &|r| of_length(-2.0 * PPM * r.distance_mm() * Reading::when(r.station == "S2")),
    );
    assert_formula(
        &effect("dead_path_offset", one, &[("offset", 8.0, "um")]),
        &|r| of_length(8.0 * UM * Reading::when(r.station == "S2")),
    );
    // At a stop the machine stands still.
    assert_formula(
        &effect(
            "timestamp_offset",
            json!({ "axis": "X" }),
            &[("offset", 5.0, "ms")],
        ),
        &|_| of_length(0.0),
    );
}

#[test]
fn set_up() {
    let one = json!({ "station": "S3" });
    let here = |r: &Reading<'_>| Reading::when(r.station == "S3");
    assert_formula(
        &vector_effect("station_drift", one.clone(), "creep", D_UM, None),
        &|r| of_station(scale(d_mm(), r.occupation_progress * here(r))),
    );
    assert_formula(
        &vector_effect("station_drift", json!({}), "creep", D_UM, None),
        &|r| of_station(scale(d_mm(), r.occupation_progress)),
    );
    for subject in [one.clone(), json!({})] {
        let one = subject != json!({});
        let mut settling = vector_effect("station_settling", subject, "settling", D_UM, None);
        let constant = json!({ "name": "time_constant", "value": 250.0, "unit": "s" });
        settling["parameters"]
            .as_array_mut()
            .unwrap()
            .push(constant);
        assert_formula(&settling, &|r| {
            let concerned = if one { here(r) } else { 1.0 };
            of_station(scale(
                d_mm(),
                concerned * (-r.occupation_elapsed_s / 250.0).exp(),
            ))
        });
    }
    assert_formula(
        &vector_effect("station_jump", one, "jump", D_UM, Some(4200.0)),
        &|r| of_station(scale(d_mm(), here(r) * Reading::when(r.time_s > 4200.0))),
    );
    for target in ["Q", "V"] {
        let subject = json!({ "target": target });
        assert_formula(
            &effect(
                "reflector_offset",
                subject.clone(),
                &[("offset", 2.5, "um")],
            ),
            &|r| of_length(2.5 * UM * Reading::when(r.target == target)),
        );
        assert_formula(
            &vector_effect("target_slip", subject.clone(), "slip", D_UM, Some(2500.0)),
            &|r| {
                let there = Reading::when(r.target == target && r.time_s > 2500.0);
                of_target(scale(r.turned(d_mm()), there))
            },
        );
        assert_formula(
            &vector_effect("target_creep", subject, "creep", D_UM, None),
            &|r| {
                let there = Reading::when(r.target == target);
                of_target(scale(r.turned(d_mm()), there * r.progress))
            },
        );
    }
    assert_formula(
        &effect(
            "fixture_expansion",
            json!({}),
            &[("expansion", 25.0, "ppm")],
        ),
        &|r| of_target(scale(sub(r.p, r.centroid), 25.0 * PPM * r.progress)),
    );
}

#[test]
fn machine() {
    assert_formula(
        &vector_effect("machine_drift", json!({}), "drift", D_UM, None),
        &|r| of_target(scale(d_mm(), r.progress)),
    );
    assert_formula(
        &vector_effect("machine_shift", json!({}), "shift", D_UM, Some(3000.0)),
        &|r| of_target(scale(d_mm(), Reading::when(r.time_s > 3000.0))),
    );
    let mut warm_up = vector_effect("warm_up", json!({}), "growth", D_UM, None);
    let constant = json!({ "name": "time_constant", "value": 1500.0, "unit": "s" });
    warm_up["parameters"].as_array_mut().unwrap().push(constant);
    assert_formula(&warm_up, &|r| {
        of_target(scale(d_mm(), 1.0 - (-r.elapsed_s / 1500.0).exp()))
    });
    // All targets on Z, wherever Y stands, and none on the table.
    assert_formula(
        &effect(
            "axis_expansion",
            json!({ "axis": "Y" }),
            &[("expansion", 20.0, "ppm")],
        ),
        &|r| {
            let grown_mm = 20.0 * PPM * r.progress * r.position("Y").unwrap_or(0.0);
            of_target([0.0, grown_mm, 0.0])
        },
    );
}

/// `T y' = ϑ - y` for ϑ that rises evenly from the first reading on.
#[test]
fn growth_with_temperatures() {
    let [_, air] = AIR;
    let [_, spindle] = SPINDLE;
    let drift = [("scale_per_k", -0.9, "ppm/K")];
    let with_air = json!({ "column": "air_temp_c" });
    assert_formula(&effect("refraction_drift", with_air, &drift), &|r| {
        of_length(-0.9 * PPM * r.distance_mm() * air * r.elapsed_s)
    });
    for lag_s in [0.0, 900.0] {
        let warmer = move |r: &Reading<'_>| match lag_s {
            0.0 => spindle * r.elapsed_s,
            _ => spindle * (r.elapsed_s - lag_s * (1.0 - (-r.elapsed_s / lag_s).exp())),
        };
        let g = [4.0, -2.0, 9.0];
        let names = ["growth_x", "growth_y", "growth_z"];
        let mut parameters = [0, 1, 2].map(|i| (names[i], g[i], "um/K")).to_vec();
        parameters.push(("time_constant", lag_s, "s"));
        for (carrier, targets) in [("Z", ["P", "Q", "K"]), ("C", ["U", "V", "W"])] {
            let subject = json!({ "carrier": carrier, "column": "machine_temp_spindle_c" });
            assert_formula(&effect("thermal_growth", subject, &parameters), &|r| {
                let there = Reading::when(targets.contains(&r.target));
                of_target(scale(g, UM * warmer(r) * there))
            });
        }
        let subject = json!({ "axis": "Y", "column": "machine_temp_spindle_c" });
        let expansion = [("expansion", 11.0, "ppm/K"), ("time_constant", lag_s, "s")];
        assert_formula(&effect("thermal_growth", subject, &expansion), &|r| {
            let q = r.position("Y").unwrap_or(0.0);
            of_target([0.0, 11.0 * PPM * q * warmer(r), 0.0])
        });
    }
}

#[test]
fn backlash_of_both_kinds_of_axes() {
    assert_formula(
        &effect(
            "backlash",
            json!({ "axis": "X" }),
            &[("lost_motion", 6.0, "um")],
        ),
        &|r| {
            let lost_mm = -3.0 * UM * r.direction * Reading::when(r.axis == "X");
            of_target([lost_mm, 0.0, 0.0])
        },
    );
    // C turns about its own axis, which A = 35° has tilted about x.
    assert_formula(
        &effect(
            "backlash",
            json!({ "axis": "C" }),
            &[("lost_motion", 9.0, "arcsec")],
        ),
        &|r| {
            let Some(tilt) = r.position("A").filter(|_| r.axis == "C") else {
                return of_target(NONE);
            };
            let c = [0.0, -tilt.sin(), tilt.cos()];
            let arm = sub(
                r.p,
                stage_motion(r.json, "A", tilt, 0.0, [200.0, 200.0, 0.0]),
            );
            let turn = scale(c, -4.5 * ARCSEC * r.direction);
            of_target(cross(turn, arm))
        },
    );
}

#[test]
fn stage_bending_with_both_kinds_of_axes() {
    for (axis, target, unit, per) in [("X", "P", "um/m2", 1e-3), ("C", "W", "um/rad2", 1.0)] {
        let c = [30.0, -12.0, 9.0];
        let names = ["bending_x", "bending_y", "bending_z"];
        let parameters = [0, 1, 2].map(|i| (names[i], c[i], unit));
        let subject = json!({ "axis": axis, "target": target });
        assert_formula(&effect("stage_bending", subject, &parameters), &|r| {
            let q = r.position(axis).unwrap_or(0.0) * per;
            let there = Reading::when(r.target == target);
            of_target(scale(r.turned(c), UM * q * q * there))
        });
    }
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// `s sin + c cos` of an angle in rad.
fn wave([s, c]: [f64; 2], angle: f64) -> f64 {
    s * angle.sin() + c * angle.cos()
}

#[test]
fn curves_of_linear_axes() {
    let x = |r: &Reading<'_>| r.position("X");
    // The lever arm of the X stage: the target against the stage's origin, which has moved along x.
    let arm = |r: &Reading<'_>, q: f64| sub(r.p, [q, 0.0, 0.0]);
    assert_formula(
        &effect(
            "scale_error",
            json!({ "axis": "X" }),
            &[("scale", 18.0, "ppm")],
        ),
        &|r| of_target([18.0 * PPM * x(r).unwrap_or(0.0), 0.0, 0.0]),
    );
    let cyclic = |component: &str, unit: &str| {
        let values = [
            ("sine", 2.0, unit),
            ("cosine", -1.5, unit),
            ("period", 43.0, "mm"),
        ];
        effect(
            "cyclic_error",
            json!({ "axis": "X", "component": component }),
            &values,
        )
    };
    let value = |q: f64| wave([2.0, -1.5], std::f64::consts::TAU * q / 43.0);
    assert_formula(&cyclic("EZX", "um"), &|r| {
        of_target([0.0, 0.0, x(r).map_or(0.0, |q| UM * value(q))])
    });
    assert_formula(&cyclic("EBX", "arcsec"), &|r| {
        of_target(x(r).map_or(NONE, |q| cross([0.0, ARCSEC * value(q), 0.0], arm(r, q))))
    });
    // b q² along y, its slope about z; 1 um/m2 is 1e-9 per mm.
    let bow = json!({ "axis": "X", "component": "EYX" });
    assert_formula(
        &effect("guideway_bow", bow, &[("bow", 40.0, "um/m2")]),
        &|r| {
            of_target(x(r).map_or(NONE, |q| {
                let turn = [0.0, 0.0, 2.0 * 40e-9 * q];
                add([0.0, 40e-9 * q * q, 0.0], cross(turn, arm(r, q)))
            }))
        },
    );
    let worn = [
        ("lost_motion_mean", 4.0, "um"),
        ("lost_motion_slope", 10.0, "um/m"),
    ];
    let worn = effect("position_dependent_backlash", json!({ "axis": "X" }), &worn);
    assert_formula(&worn, &|r| {
        let lost_um = x(r).map_or(0.0, |q| 4.0 + 10.0 * (q - 200.0) * 1e-3);
        let moving = Reading::when(r.axis == "X");
        of_target([-0.5 * UM * r.direction * lost_um * moving, 0.0, 0.0])
    });
}

#[test]
fn curves_of_rotary_axes() {
    let c_centre =
        |r: &Reading<'_>, tilt| stage_motion(r.json, "A", tilt, 0.0, [200.0, 200.0, 0.0]);
    // Positions of A and C for a target on the table.
    let table = |r: &Reading<'_>| r.position("A").zip(r.position("C"));
    for (id, waves) in [("encoder_eccentricity", 1.0), ("encoder_ellipticity", 2.0)] {
        let values = [("sine", 3.0, "arcsec"), ("cosine", -2.0, "arcsec")];
        assert_formula(&effect(id, json!({ "axis": "C" }), &values), &|r| {
            of_target(table(r).map_or(NONE, |(tilt, q)| {
                let c = [0.0, -tilt.sin(), tilt.cos()];
                let turn = scale(c, ARCSEC * wave([3.0, -2.0], waves * q));
                cross(turn, sub(r.p, c_centre(r, tilt)))
            }))
        });
    }
    let worm = [
        ("sine", 3.0, "arcsec"),
        ("cosine", -2.0, "arcsec"),
        ("waves", 72.0, "1"),
    ];
    assert_formula(&effect("worm_gear", json!({ "axis": "A" }), &worm), &|r| {
        of_target(table(r).map_or(NONE, |(q, _)| {
            let turn = [ARCSEC * wave([3.0, -2.0], 72.0 * q), 0.0, 0.0];
            cross(turn, sub(r.p, [0.0, 200.0, 40.0]))
        }))
    });
    let wobble = [
        ("sine_b", 3.0, "arcsec"),
        ("cosine_b", -2.0, "arcsec"),
        ("sine_c", 1.0, "arcsec"),
        ("cosine_c", 2.5, "arcsec"),
        ("waves", 2.0, "1"),
    ];
    assert_formula(
        &effect("axis_wobble", json!({ "axis": "A" }), &wobble),
        &|r| {
            of_target(table(r).map_or(NONE, |(q, _)| {
                let tilts = [0.0, wave([3.0, -2.0], 2.0 * q), wave([1.0, 2.5], 2.0 * q)];
                cross(scale(tilts, ARCSEC), sub(r.p, [0.0, 200.0, 40.0]))
            }))
        },
    );
    // Of C in the frame of the table that A tilts.
    let runout = [
        ("sine_x", 3.0, "um"),
        ("cosine_x", -2.0, "um"),
        ("sine_y", 1.0, "um"),
        ("cosine_y", 2.5, "um"),
        ("waves", 3.0, "1"),
    ];
    assert_formula(
        &effect("axis_runout", json!({ "axis": "C" }), &runout),
        &|r| {
            of_target(table(r).map_or(NONE, |(tilt, q)| {
                let [x, y] = [wave([3.0, -2.0], 3.0 * q), wave([1.0, 2.5], 3.0 * q)];
                scale([x, y * tilt.cos(), y * tilt.sin()], UM)
            }))
        },
    );
}

#[test]
fn one_axis_on_the_position_of_another() {
    let pair = |axis: &str, other: &str| json!({ "axis": axis, "other_axis": other });
    let names = ["coupling_x", "coupling_y", "coupling_z"];
    let c = [30.0, -12.0, 9.0];
    let parameters = [0, 1, 2].map(|i| (names[i], c[i], "um/m2"));
    assert_formula(
        &effect("cross_coupling", pair("X", "Z"), &parameters),
        &|r| {
            let product = r
                .position("X")
                .zip(r.position("Z"))
                .map_or(0.0, |(x, z)| x * z);
            of_target(scale(c, UM * 1e-6 * product))
        },
    );
    // z = c x y, and the stage of Y tilts by its slope c x about +x, about where Y stands.
    let sag = json!({ "axis": "Y", "other_axis": "X", "component": "EZY" });
    assert_formula(
        &effect("cross_coupling", sag, &[("sag", 40.0, "um/m2")]),
        &|r| {
            let (Some(x), Some(y)) = (r.position("X"), r.position("Y")) else {
                return of_target(NONE);
            };
            let tilt = [40.0 * UM * 1e-6 * x, 0.0, 0.0];
            let arm = sub(r.p, [x, y, 0.0]);
            of_target(add([0.0, 0.0, 40.0 * UM * 1e-6 * x * y], cross(tilt, arm)))
        },
    );
    // C0Y turns Y to -x, B0Z turns Z to +x, A0Z turns Z to -y.
    for (axis, other, d) in [
        ("Y", "X", [-1.0, 0.0, 0.0]),
        ("Z", "X", [1.0, 0.0, 0.0]),
        ("Z", "Y", [0.0, -1.0, 0.0]),
    ] {
        let parameters = [("squareness", 7.0, "arcsec")];
        assert_formula(
            &effect("squareness_error", pair(axis, other), &parameters),
            &|r| of_target(scale(d, 7.0 * ARCSEC * r.position(axis).unwrap_or(0.0))),
        );
    }
}
