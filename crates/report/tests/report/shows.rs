//! The page shows what the files say, in the units and to the digits that people read.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};
use trueaxis_report::report;

/// A machine with X and Y, squareness, and one curve that is 4 µm at most.
fn calibration() -> Value {
    json!({
        "format": "trueaxis-calibration", "version": 1, "campaign": "two axes",
        "machine": { "name": "M", "axes": [
            { "name": "X", "kind": "linear", "direction": [1, 0, 0], "travel": [0, 400] },
            { "name": "Y", "kind": "linear", "direction": [0, 1, 0], "travel": [0, 300] },
            { "name": "C", "kind": "rotary", "direction": [0, 0, 1], "travel": [0, 360] } ] },
        "adjustment": { "observations": 100, "degrees_of_freedom": 40, "sigma0": 1.02, "p_value": 0.4, "rejected": [] },
        "stations": [ { "name": "S1", "position_mm": [900, 0, 100] } ],
        "targets": [ { "name": "P", "position_mm": [1, 2, 3] } ],
        "axes": [
            { "name": "X", "kind": "linear", "positions": [0, 200, 400], "components": {
                "EZX": { "value_um": [0.0, 4.0, -2.5], "u_um": [0.0, 0.25, 0.3], "dof": 9.0 } } } ],
        "location_errors": {
            "C0Y": { "value_arcsec": -23.417, "u_arcsec": 0.275 },
            "X0C": { "value_mm": 0.0142726, "u_mm": 0.000115, "relative_to": "targets" } },
    })
}

fn diagnosis(verdict: &str) -> Value {
    let cause = json!({ "effect": "backlash", "level": "lengths", "subject": { "axis": "X" }, "layer": "machine",
        "p_value": 1e-9, "parameters": [ { "name": "lost_motion", "value": 3.743, "u": 0.257, "unit": "um" } ],
        "fitted": { "of": "lengths from S1 to P", "against": "X", "unit": "mm", "at": [0.0, 200.0, 0.0, 200.0],
            "direction": [1, 1, -1, -1], "misfit_um": [2.0, 1.7, -1.6, -1.9], "fitted_um": [1.8, 1.8, -1.8, -1.8],
            "u_um": [0.3, 0.3, 0.3, 0.3], "beside": [ { "of": "lengths from S1 to Q", "against": "X", "unit": "mm", "at": [0.0],
            "direction": [1], "misfit_um": [0.4], "fitted_um": [0.5] } ] } });
    let causes = if verdict == "named" {
        vec![cause]
    } else {
        Vec::new()
    };
    json!({ "format": "trueaxis-diagnosis", "version": 1, "campaign": "two axes", "verdict": verdict, "causes": causes })
}

fn page(folder: &Path, files: &[(&str, &Value)]) -> String {
    for (name, value) in files {
        std::fs::write(folder.join(name), value.to_string()).unwrap();
    }
    report(folder, None).unwrap().html
}

#[track_caller]
fn has(page: &str, parts: &[&str]) {
    for part in parts {
        assert!(page.contains(part), "{part} is not on the page");
    }
}

#[test]
fn numbers_have_their_uncertainty_and_unit() {
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path(), &[("calibration.json", &calibration())]);
    has(&page, &["squareness of Y to X", "−23.42″", "0.55″"]);
    has(
        &page,
        &["offset of C in the X direction", "+14.27 µm", "0.23 µm"],
    );
    // t₀.₉₇₅ of 9 degrees of freedom is 2.262: U of 0.25 µm is 0.57 µm, the largest one 0.68 µm.
    has(
        &page,
        &[
            "straightness of X in the Z direction",
            "X = 200 mm: EZX = +4.00 ± 0.57 µm",
            ">0.68<",
        ],
    );
    // 23.417″ on 300 mm make 34 µm: more than the curve. What is relative to nests is no error of the machine.
    let largest = page.split("The largest errors").nth(1).unwrap();
    let largest = largest.split("</table>").next().unwrap();
    let at = |text: &str| largest.find(text);
    assert!(at("34 µm").is_some() && at("C0Y") < at("EZX"), "{largest}");
    assert!(at("X0C").is_none());
    let says = [
        "on half the diagonal of the travels",
        "relative to the nests (*) are not among these",
    ];
    has(&page, &says);
    // A table alone has no travel: its lever is the farthest target.
    let mut table = calibration();
    let is_rotary = |axis: &Value| axis["kind"] == "rotary";
    table["machine"]["axes"]
        .as_array_mut()
        .unwrap()
        .retain(is_rotary);
    table["axes"] = json!([]);
    table["targets"][0]["position_mm"] = json!([300, 0, 400]);
    let page = self::page(folder.path(), &[("calibration.json", &table)]);
    // 23.417″ at 500 mm.
    has(&page, &["at the distance of the farthest target", "57 µm"]);
}

#[test]
fn the_verdict_follows_residuals_and_diagnosis() {
    let sound = calibration();
    let mut contradicted = calibration();
    contradicted["adjustment"]["p_value"] = json!(1e-9);
    let of = |calibration: &Value, verdict: Option<&str>| {
        let folder = tempfile::tempdir().unwrap();
        let diagnosis = verdict.map(diagnosis);
        let mut files = vec![("calibration.json", calibration)];
        files.extend(
            diagnosis
                .as_ref()
                .map(|diagnosis| ("diagnosis.json", diagnosis)),
        );
        page(folder.path(), &files)
    };
    has(
        &of(&sound, None),
        &["verdict good", "hidden causes were not sought"],
    );
    let mut left_handed = calibration();
    left_handed["location_errors"]["B0C"] = json!({ "value_arcsec": -72202.8, "u_arcsec": 0.2 });
    let says = [
        "verdict care",
        "no machine has such errors",
        "B0C is −20.06°: see the notices.",
    ];
    has(&of(&left_handed, Some("clean")), &says);
    has(
        &of(&sound, Some("clean")),
        &["verdict good", "The calibration is sound"],
    );
    has(&of(&sound, Some("not_judged")), &["verdict care"]);
    has(
        &of(&sound, Some("named")),
        &[
            "verdict bad",
            "backlash of axis X",
            "lost motion +3.74 ± 0.51\u{a0}µm",
            "X = 200.0 mm: −1.90 ± 0.60, cause −1.80 µm",
            "X = 0.0 mm: +0.40, cause +0.50 µm",
            "orange dashed: backward",
        ],
    );
    // More noise than declared is no contradiction of the model, unless a step contradicts the rest.
    let louder = "1.02 times what the declared noise explains";
    has(
        &of(&contradicted, Some("clean")),
        &["verdict care", "The noise is more than declared", louder],
    );
    contradicted["misfits"] = json!([{ "step": "run x at X = 20.0 mm", "p_value": 1e-6 }]);
    has(
        &of(&contradicted, Some("clean")),
        &[
            "verdict bad",
            louder,
            "contradicts the rest: run x at X = 20.0 mm",
        ],
    );
}

/// A count of waves has neither a unit nor an uncertainty.
#[test]
fn waves_are_counted() {
    let mut named = diagnosis("named");
    named["causes"][0]["parameters"] = json!([
        { "name": "amplitude", "value": 5.2, "u": 0.1, "unit": "arcsec" },
        { "name": "waves", "value": 16.0, "u": 0.0, "unit": "1" } ]);
    let folder = tempfile::tempdir().unwrap();
    let shown = page(folder.path(), &[("diagnosis.json", &named)]);
    has(&shown, &["amplitude +5.20 ± 0.20″; 16 waves per turn"]);
}

/// Each verification has causes of its own in its bar; without a calibration nothing is said of one.
#[test]
fn readings_alone_have_their_own_verdict_and_causes() {
    let cause = |effect: &str, data: &str| json!({ "effect": effect, "level": "verification", "data": [data] });
    let level = |data: &str| json!({ "level": "verification", "data": data, "shares": { "causes": [0.7], "disturbances": [], "unexplained": 0.1, "noise": 0.2 } });
    let named = json!({ "format": "trueaxis-diagnosis", "version": 1, "campaign": "bars", "verdict": "named",
        "causes": [cause("scale_error", "bar A"), cause("backlash", "bar B")], "levels": [level("bar A"), level("bar B")] });
    let folder = tempfile::tempdir().unwrap();
    let shown = page(folder.path(), &[("diagnosis.json", &named)]);
    has(
        &shown,
        &[
            "aria-label=\"scale error 70 %, unexplained 10 %, noise 20 %\"",
            "aria-label=\"backlash 70 %, unexplained 10 %, noise 20 %\"",
            "verdict bad",
            "The readings hold more than noise",
        ],
    );
    assert!(!shown.contains("rigid machine model"));
}

#[test]
fn what_belongs_to_other_data_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut stranger = diagnosis("named");
    stranger["campaign"] = json!("another");
    let files = [
        ("calibration.json", &calibration()),
        ("diagnosis.json", &stranger),
    ];
    let page = page(folder.path(), &files);
    has(
        &page,
        &["diagnosis.json is of another campaign", "verdict good"],
    );
    assert!(!page.contains("backlash"));
}

/// What an earlier calibration or other lengths led to, under the same name of the campaign.
#[test]
fn what_rests_on_other_files_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str, sha256: &str| json!({ "inputs": [ { "name": name, "sha256": sha256 } ] });
    let (mut calibration, mut diagnosis) = (calibration(), diagnosis("named"));
    calibration["traceability"] = of("lengths.csv", "12ab");
    diagnosis["traceability"] = of("lengths.csv", "12ab");
    let mut volume = json!({ "format": "trueaxis-volume", "version": 1, "campaign": "two axes", "places": 8,
        "before": { "zeroed_at_home": { "rms_um": {} }, "best_fit": {} }, "after": {} });
    volume["traceability"] = of("calibration.json", "34cd");
    let mut montecarlo = json!({ "format": "trueaxis-montecarlo", "version": 1, "campaign": "two axes", "trials": 500, "seed": 17 });
    montecarlo["traceability"] = of("lengths.csv", "12ab");
    let files = [
        ("calibration.json", &calibration),
        ("diagnosis.json", &diagnosis),
        ("volume.json", &volume),
        ("montecarlo.json", &montecarlo),
    ];
    let shown = page(folder.path(), &files);
    has(
        &shown,
        &[
            "backlash",
            "500 trials, seed 17",
            "volume.json is of another calibration and left out",
        ],
    );
    diagnosis["traceability"] = of("lengths.csv", "56ef");
    let shown = page(folder.path(), &[("diagnosis.json", &diagnosis)]);
    has(
        &shown,
        &["diagnosis.json is of other measurements and left out"],
    );
    montecarlo["traceability"] = of("lengths.csv", "56ef");
    let shown = page(folder.path(), &[("montecarlo.json", &montecarlo)]);
    let says = "montecarlo.json is of other measurements and left out";
    has(&shown, &[says]);
    assert!(!shown.contains("seed 17"));
    assert!(!shown.contains("backlash"));
}

#[test]
fn readings_stand_beside_their_prediction() {
    let point = |x: f64, read: f64| {
        json!({ "at": { "X": x, "Y": 0 }, "direction": 1, "readings": 5, "reading_um": read, "predicted_um": 12.9,
            "first_order_um": 12.9, "compensated_um": 0.0, "u_prediction_um": 0.5, "u_reading_um": 0.3, "e_n": 0.26 })
    };
    let mut verification = json!({
        "format": "trueaxis-verification", "version": 1, "calibration": "two axes", "expected_above_one": 0.0455,
        "verification": [ { "name": "LI along X", "kind": "positioning", "points": [point(0.0, 13.2), point(200.0, 12.6)],
            "e_n": { "count": 2, "above_one": 0, "misfit": false },
            "iso_230_2": [ { "from": {}, "runs": 5, "forward": { "A_um": 31.2, "E_um": 30.4, "R_um": 0.9 }, "M_um": 30.3 } ] } ] });
    let folder = tempfile::tempdir().unwrap();
    let files = [
        ("calibration.json", &calibration()),
        ("verification.json", &verification),
    ];
    let shown = page(folder.path(), &files);
    has(
        &shown,
        &[
            "LI along X",
            "X = 200 mm, forward: read +12.6 µm, predicted +12.9 ± 1.0 µm",
            "less the prediction 0.30 µm",
        ],
    );
    has(
        &shown,
        &["0 of 2 normalised errors", "X in mm", ">31.2<", "M 30.3 µm"],
    );
    // On a circle two points have one position of X.
    verification["verification"][0]["points"] =
        json!([point(0.0, 13.2), point(200.0, 12.6), point(0.0, 12.0)]);
    let files = [
        ("calibration.json", &calibration()),
        ("verification.json", &verification),
    ];
    has(
        &page(folder.path(), &files),
        &[">number of the reading</text>"],
    );
    // A reading that contradicts the prediction is no clean bill; alone, the file makes a page of its own.
    verification["verification"][0]["e_n"]["misfit"] = json!(true);
    let files = [
        ("calibration.json", &calibration()),
        ("verification.json", &verification),
    ];
    has(
        &page(folder.path(), &files),
        &["verdict care", "other readings contradict it"],
    );
    let alone = tempfile::tempdir().unwrap();
    has(
        &page(alone.path(), &[("verification.json", &verification)]),
        &["verdict bad", "LI along X"],
    );
    verification["calibration"] = json!("another");
    let files = [
        ("calibration.json", &calibration()),
        ("verification.json", &verification),
    ];
    has(
        &page(folder.path(), &files),
        &["verification.json is of another calibration"],
    );
}

/// Without a calibration in the folder the file itself says which axes turn.
#[test]
fn positions_have_their_unit() {
    let point = |c: f64| json!({ "at": { "X": 0, "C": c }, "direction": 1, "reading_um": 1.0, "predicted_um": 2.0, "compensated_um": 0.0 });
    let verification = json!({
        "format": "trueaxis-verification", "version": 1, "rotary_axes": ["C"],
        "verification": [ { "name": "DBB", "kind": "ballbar", "points": [point(0.0), point(90.0)] } ] });
    let folder = tempfile::tempdir().unwrap();
    let alone = page(folder.path(), &[("verification.json", &verification)]);
    has(&alone, &["C in °", "C = 90°"]);
    assert!(!alone.contains("C in mm"));
}

/// Quarter turns in X and Y, read 4 µm longer at +X and 2 µm shorter at +Y: as far from the circle as the names say.
#[test]
fn a_ball_bar_has_a_polar_plot() {
    let point = |x: f64, y: f64, um: f64| json!({ "at": { "X": x, "Y": y, "Z": 7 }, "direction": 1, "reading_um": um, "predicted_um": 0.0, "compensated_um": 0.0 });
    let around = [
        point(400.0, 250.0, 4.0),
        point(300.0, 350.0, -2.0),
        point(200.0, 250.0, 0.0),
        point(300.0, 150.0, 0.0),
    ];
    let of = |points: &[Value]| {
        let verification = json!({
            "format": "trueaxis-verification", "version": 1,
            "verification": [ { "name": "DBB", "kind": "ballbar", "points": points } ] });
        let folder = tempfile::tempdir().unwrap();
        page(folder.path(), &[("verification.json", &verification)])
    };
    // Centre 180, circle 90, and 62 for 4 µm.
    has(
        &of(&around),
        &["+X", "+Y", "M332 180h0M180 121h0M90 180h0M180 270h0"],
    );
    // On a straight line there is no circle.
    let line = [0.0, 1.0, 2.0, 4.0].map(|x| point(x, x, 1.0));
    assert!(!of(&line).contains("polar\"><figure"));
}

/// U of 0.3 µm read and 0.4 µm predicted is that of their difference, 1 µm.
#[test]
fn point_checks_have_a_figure() {
    let point = |coordinate: &str, um: f64| {
        json!({ "at": { "X": 5 }, "point_mm": [5, 95, -450], "coordinate": coordinate, "reading_um": um, "u_reading_um": 0.3,
            "predicted_um": 2.0, "u_prediction_um": 0.4, "compensated_um": 0.0, "e_n": 0.5 })
    };
    let verification = json!({
        "format": "trueaxis-verification", "version": 1,
        "verification": [ { "name": "plate", "kind": "points", "points": [point("x", 2.5), point("z", 2.0)] } ] });
    let folder = tempfile::tempdir().unwrap();
    let shown = page(folder.path(), &[("verification.json", &verification)]);
    let x = "x at (+5.0, +95.0, −450.0) mm: read +2.5 µm, predicted +2.0 ± 0.8 µm, Eₙ 0.50";
    // From -0.5 to 1.5 µm, of -1.15 to 1.65 µm on 222 pixels.
    has(
        &shown,
        &[
            x,
            "M260.5 178.5L260.5 19.9",
            "z at (+5.0",
            "number of the place",
        ],
    );
}

/// U (k = 2) of the noise of both; what follows from other positions is no change.
#[test]
fn a_comparison_says_what_has_changed() {
    let mut comparison = json!({
        "format": "trueaxis-comparison", "version": 1, "machine": "M", "first": "last year", "second": "two axes", "rotary_axes": ["C"],
        "differences": {
            "EXC": { "difference_um": [0, 9, 1], "u_um": [0, 1, 1], "positions": [0, 90, 180], "beyond_noise": 1 },
            "EBC": { "difference_arcsec": [0, 9], "u_arcsec": [0, 1], "positions": [0, 90], "beyond_noise": 1, "follows_from_other_steps": true },
            "C0Y": { "difference_arcsec": [0.5], "u_arcsec": [0.2], "beyond_noise": 0 } } });
    let of = |comparison: &Value, calibration: Option<&Value>| {
        let folder = tempfile::tempdir().unwrap();
        let mut files = vec![("comparison.json", comparison)];
        files.extend(calibration.map(|calibration| ("calibration.json", calibration)));
        page(folder.path(), &files)
    };
    let says = "1 of the 3 errors changed by more than the noise since “last year”: EXC.";
    let alone = of(&comparison, None);
    has(
        &alone,
        &[
            "verdict care",
            "The machine has changed.",
            says,
            "C = 90°: EXC changed by +9.0 ± 2.0 µm",
        ],
    );
    has(
        &alone,
        &[
            "changed at 1 of 3 positions",
            "measured at other positions; differs at 1 of 2",
            "+0.50 ± 0.40″",
        ],
    );
    has(
        &of(&comparison, Some(&calibration())),
        &["verdict good", says, "Changes since last year"],
    );
    comparison["second"] = json!("another");
    has(
        &of(&comparison, Some(&calibration())),
        &["comparison.json is of another calibration and left out."],
    );
    comparison["differences"]["EXC"]["beyond_noise"] = json!(0);
    has(
        &of(&comparison, None),
        &["verdict good", "None of the 3 errors has changed"],
    );
    comparison["differences"]["C0Y"] = json!({ "difference_arcsec": [0.5], "u_arcsec": [null] });
    has(
        &of(&comparison, None),
        &["verdict care", "is not known", "+0.50″"],
    );
}

/// Points have coordinates where lengths have stations, and the rms says whether they are of this calibration.
#[test]
fn coordinates_have_their_residuals() {
    let folder = tempfile::tempdir().unwrap();
    let table = "row,coordinate,target,run,time_s,X,residual_um,standardized,redundancy,used\n\
                 2,x,P,x,0,0,3,1.0,0.3,1\n2,y,P,x,0,0,-3,-1.0,0.3,1\n2,z,P,x,0,0,3,4.1,0.05,1\n\
                 3,x,P,x,9,100,-3,1.0,0.3,1\n3,y,P,x,9,100,3,-1.0,0.3,1\n3,z,P,x,9,100,-3,0.1,0.05,1\n";
    std::fs::write(folder.path().join("residuals.csv"), table).unwrap();
    let mut calibration = calibration();
    calibration["adjustment"]["rms_residual_um"] = json!(3.0);
    let shown = page(folder.path(), &[("calibration.json", &calibration)]);
    has(
        &shown,
        &[
            "in time, by coordinate",
            "rms by coordinate and target",
            "line 2: z of P, 3.00 µm, 4.10 standard deviations",
            "2 coordinates show less than a tenth of an error",
            "Points that contradict the others of their step are left out",
        ],
    );
    calibration["adjustment"]["noise_declared"] = json!(false);
    let shown = page(folder.path(), &[("calibration.json", &calibration)]);
    has(&shown, &["rms residual; not all noise is declared"]);
    assert!(!shown.contains("sigma0"));
    calibration["adjustment"]["rms_residual_um"] = json!(3.1);
    let shown = page(folder.path(), &[("calibration.json", &calibration)]);
    has(&shown, &["residuals.csv is not of this calibration"]);
}

/// Many lengths make neither a large page nor one that hides what stands out.
#[test]
fn many_residuals_are_thinned() {
    const MANY: usize = 120_000;
    const FAR: usize = 77_777;
    let folder = tempfile::tempdir().unwrap();
    let mut table =
        "row,station,target,run,time_s,X,residual_um,standardized,redundancy,used\n".to_owned();
    for k in 0..MANY {
        // In (-1, 1), without a period that thinning could meet.
        let residual = if k == FAR {
            9.0
        } else {
            (k as f64 * 0.7).sin()
        };
        writeln!(
            table,
            "{},S{},P,x,{k},{},{residual},{residual},0.5,1",
            k + 2,
            k % 7,
            k % 400
        )
        .unwrap();
    }
    std::fs::write(folder.path().join("residuals.csv"), table).unwrap();
    let mut calibration = calibration();
    calibration["adjustment"]["observations"] = json!(MANY);
    let page = page(folder.path(), &[("calibration.json", &calibration)]);
    assert!(page.len() < 1_000_000, "{} bytes", page.len());
    has(
        &page,
        &[
            "Of 120000 lengths",
            "show one in 12,",
            "line 77779: S0 to P",
            // Colours are six; the seventh station has crosses.
            "<i class=\"i0 x\"></i>S6",
            "class=\"p0 x\"",
        ],
    );
}
