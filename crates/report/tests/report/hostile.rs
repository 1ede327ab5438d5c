//! Whatever stands in the files is text on the page, and nothing in them breaks it.

use std::path::Path;

use proptest::prelude::*;
use serde_json::{Value, json};
use trueaxis_report::{Error, report};

/// A folder of results in which each name and note is made by `name`, and each number is `number`.
fn write(folder: &Path, name: &dyn Fn(usize) -> String, number: &Value) {
    let point = json!([number, number, number]);
    let curve = json!({ "value_um": [number, 1.0], "u_um": [number, 0.5], "dof": number });
    let calibration = json!({
        "format": "trueaxis-calibration", "version": 1, "campaign": name(0), "method": name(1),
        "machine": { "name": name(2), "axes": [
            { "name": name(3), "kind": "linear", "direction": [1, 0, 0], "travel": [0, number] } ] },
        "adjustment": { "observations": 1, "degrees_of_freedom": 1, "sigma0": number, "p_value": number,
            "rejected": [ { "row": 2, "reason": name(4), "error_um": number, "u_um": number } ] },
        "stations": [ { "name": name(5), "position_mm": point } ],
        "targets": [ { "name": name(6), "position_mm": [1.0, 2.0, 3.0] }, { "name": name(7), "position_mm": point } ],
        "axes": [ { "name": name(3), "kind": "linear", "positions": [number, 20.0], "components": { "EXX": curve } } ],
        "location_errors": { name(8): { "value_arcsec": number, "u_arcsec": number } },
        "notices": [name(9)],
        "traceability": { "operator": name(10), "instrument": name(11), "inputs": [ { "name": name(12), "sha256": name(13) } ] },
    });
    let diagnosis = json!({
        "format": "trueaxis-diagnosis", "version": 1, "campaign": name(0), "verdict": "named",
        "causes": [ { "effect": name(14), "level": "lengths", "subject": { "station": name(5) }, "cause": name(15),
            "action": name(16), "parameters": [ { "name": name(17), "value": number, "u": number, "unit": name(18) } ],
            "component_change": { name(19): { "max_um": number } },
            "fitted": { "of": name(23), "against": name(3), "unit": name(18), "at": [0.0, number], "direction": [1],
                "misfit_um": [number, 1.0, 2.0], "fitted_um": [1.0, number], "u_um": [number],
                "beside": [ { "of": name(24), "against": name(3), "unit": name(18), "at": [0.0, number], "misfit_arcsec": [number],
                    "fitted_arcsec": [number], "u_arcsec": [1.0] } ] },
            "data": [name(20)], "layer": name(25), "consequence": name(26), "separate_by": name(27),
            "cannot_tell_apart_from": [ { "effect": name(28), "subject": { "target": name(6) }, "delta_bic": number } ],
            "follows": { "column": name(29), "plausible": false } },
            { "effect": name(14), "level": "components", "subject": { "axis": name(3) }, "cause": name(15), "consequence": name(26),
            "action": name(16), "separate_by": name(27), "data": [name(20)] } ],
        "disturbances": [ { "subject": { "station": name(5) }, "varies_with": [name(30)], "rms_um": number,
            "correlation_length": { "value": number, "unit": name(18) },
            "curve": [ { "at": [number], "value_um": [number, 1.0], "u_um": [1.0, number] }, { "at": [1.0], "value_um": [1.0], "u_um": [] } ] } ],
        "unexplained": { "rms_um": number, "varies_with": [name(30)], "note": name(31) },
        "rejected": [ { "file": name(32), "row": 2, "error_um": number, "u_um": number, "reason": name(4) } ],
        "not_observable": [ { "effect": name(14), "subject": name(33), "reason": name(34), "measure": name(35) } ],
        "levels": [ { "level": "lengths", "data": name(20), "noise_floor_um": 1.0, "before": { "rms_um": 2.0 },
            "after": { "rms_um": 1.5 }, "places": [ { "by": "station", "name": name(5), "before_um": number, "after_um": 1.0 } ] } ],
        "notices": [name(21)],
    });
    let verification = json!({
        "format": "trueaxis-verification", "version": 1, "calibration": name(0), "expected_above_one": number,
        "verification": [ { "name": name(36), "kind": name(37),
            "points": [ { "at": { name(3): number }, "direction": 1, "readings": 5, "reading_um": number, "predicted_um": 1.0,
                "compensated_um": number, "u_prediction_um": number, "u_reading_um": 1.0, "e_n": number } ],
            "iso_230_4": { name(38): number } },
            { "name": name(36), "kind": "ballbar", "points": [
                { "at": { name(3): number, name(8): 1.0 }, "direction": 1, "reading_um": number, "predicted_um": 1.0, "compensated_um": 2.0 },
                { "at": { name(3): 1.0, name(8): 3.0 }, "direction": 1, "reading_um": 1.0, "predicted_um": 1.0, "compensated_um": 2.0 },
                { "at": { name(3): 2.0, name(8): 1.0 }, "direction": -1, "reading_um": 1.0, "predicted_um": number, "compensated_um": 2.0 } ] },
            { "name": name(36), "kind": "points", "points": [ { "at": { name(3): number }, "point_mm": [number, 1.0, 2.0],
                "coordinate": "y", "reading_um": number, "predicted_um": 1.0, "compensated_um": 2.0 } ] } ] });
    let comparison = json!({
        "format": "trueaxis-comparison", "version": 1, "machine": name(1), "first": name(39), "second": name(0),
        "rotary_axes": [name(3)], "differences": { name(8): { "difference_um": [number, 1.0], "u_um": [1.0, number],
            "positions": [number, 2.0], "beyond_noise": 1 } } });
    std::fs::write(folder.join("comparison.json"), comparison.to_string()).unwrap();
    std::fs::write(folder.join("verification.json"), verification.to_string()).unwrap();
    std::fs::write(folder.join("calibration.json"), calibration.to_string()).unwrap();
    std::fs::write(folder.join("diagnosis.json"), diagnosis.to_string()).unwrap();
    let quoted = |k| format!("\"{}\"", name(k).replace('"', "\"\""));
    let residuals = format!(
        "row,station,target,run,time_s,{},residual_um,standardized,redundancy,used\n2,{},{},{},1,0,{number},4,0.5,1\n",
        quoted(3),
        quoted(5),
        quoted(6),
        quoted(22)
    );
    std::fs::write(folder.join("residuals.csv"), residuals).unwrap();
}

/// The names of all tags in their order: what a browser makes elements of. An attribute that ends early shows as a
/// quote or an angle bracket that is left over.
fn tags(html: &str) -> Vec<String> {
    let mut tags = Vec::new();
    let mut rest = html;
    while let Some(start) = rest.find('<') {
        rest = &rest[start + 1..];
        let is_name = |c: char| c.is_ascii_alphanumeric() || "/!".contains(c);
        let name: String = rest.chars().take_while(|c| is_name(*c)).collect();
        // Names of attributes with their quotes: text inside these does not count.
        let mut quoted = false;
        let mut shape = String::new();
        let mut end = rest.len();
        for (k, c) in rest.char_indices() {
            match c {
                '"' => quoted = !quoted,
                '>' if !quoted => {
                    end = k;
                    break;
                }
                c if !quoted => shape.push(c),
                _ => {}
            }
        }
        // Scripts and styles are ours; they are the same on all pages.
        let raw = ["script", "style"].into_iter().find(|raw| name == *raw);
        rest = &rest[end..];
        if let Some(raw) = raw {
            let close = rest.find(&format!("</{raw}")).unwrap_or(rest.len());
            rest = &rest[close..];
        }
        tags.push(shape);
    }
    tags
}

fn html(name: &dyn Fn(usize) -> String, number: &Value) -> (String, Vec<(String, String)>) {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), name, number);
    let report = report(folder.path(), None).unwrap();
    (report.html, report.figures)
}

fn hostile() -> impl Strategy<Value = String> {
    let bait = prop::sample::select(vec![
        "<script>alert(1)</script>",
        "</script><img src=x onerror=alert(1)>",
        "\"><svg onload=alert(1)>",
        "' onmouseover='alert(1)",
        "{{ 7 * 7 }}{% raw %}",
        "</style><b>",
        "<!--",
        "]]>",
        "&lt;",
        "\u{202e}\u{0}\u{7f}",
        "line\nbreak",
        "",
        "../../etc/passwd",
    ]);
    let text = proptest::collection::vec(any::<char>(), 0..12)
        .prop_map(|chars| chars.into_iter().collect());
    prop_oneof![bait.prop_map(str::to_owned), text]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// A page with hostile names has the elements of the page with letters in their place.
    #[test]
    fn names_and_notes_are_text(bait in hostile()) {
        // Different names stay different, and text of one length leaves the figures their labels.
        let named = |k: usize| format!("{bait}{k:02}");
        let letters = |k: usize| format!("{}{k:02}", "x".repeat(bait.chars().count()));
        let number = json!(1.5);
        let (page, figures) = html(&named, &number);
        let (expected, plain) = html(&letters, &number);
        prop_assert_eq!(tags(&page), tags(&expected));
        prop_assert_eq!(figures.len(), plain.len());
        for ((name, svg), (_, plain)) in figures.iter().zip(&plain) {
            prop_assert!(!name.contains(['/', '\\', '<', ' ', '\0']), "{}", name);
            prop_assert_eq!(tags(svg), tags(plain));
        }
    }
}

/// Numbers that mean nothing, and none at all, leave a page.
#[test]
fn any_number_is_shown() {
    let named = |k: usize| format!("n{k}");
    for number in [
        json!(1e308),
        json!(-1e308),
        json!(5e-324),
        json!(0),
        json!(-0.0),
        json!(1e17),
    ] {
        let (page, _) = html(&named, &number);
        assert!(
            page.ends_with("</html>") || page.ends_with("</html>\n"),
            "{number}"
        );
        assert!(!page.contains("NaN"), "{number}");
    }
    let folder = tempfile::tempdir().unwrap();
    let empty = r#"{ "format": "trueaxis-calibration", "version": 1 }"#;
    std::fs::write(folder.path().join("calibration.json"), empty).unwrap();
    report(folder.path(), None).unwrap();
    let empty = r#"{ "format": "trueaxis-diagnosis", "version": 1, "causes": [ { "effect": "", "fitted": {} } ], "levels": [ {} ],
        "disturbances": [ {} ], "not_observable": [ {} ] }"#;
    std::fs::write(folder.path().join("diagnosis.json"), empty).unwrap();
    report(folder.path(), None).unwrap();
}

#[test]
fn what_is_no_result_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let refused = || report(folder.path(), None).unwrap_err();
    assert!(matches!(refused(), Error::NothingToReport { .. }));
    let file = folder.path().join("calibration.json");
    std::fs::write(&file, "{").unwrap();
    assert!(matches!(refused(), Error::NotAResult { .. }));
    std::fs::write(
        &file,
        r#"{ "format": "trueaxis-calibration", "version": 2 }"#,
    )
    .unwrap();
    assert!(refused().to_string().contains("trueaxis-calibration 1"));
    std::fs::write(
        &file,
        r#"{ "format": "trueaxis-calibration", "version": 1, "axes": 3 }"#,
    )
    .unwrap();
    assert!(matches!(refused(), Error::NotAResult { .. }));
}

#[test]
fn a_template_of_ones_own() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &|k| format!("n{k}"), &json!(2));
    let of = |template: &str| report(folder.path(), Some(template));
    let page =
        of("{{ campaign }} {{ calibration.adjustment.sigma0 }} {{ no.such.thing }}").unwrap();
    assert_eq!(page.html, "n0 2 ");
    let error = of("{% for %}").unwrap_err().to_string();
    assert!(error.contains("template"), "{error}");
}
