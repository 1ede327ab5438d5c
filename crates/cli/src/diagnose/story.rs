//! A diagnosis in a dozen lines.

use trueaxis_diagnose::{Cause, Diagnosis, Disturbance, LevelReport, Place, Unexplained, Verdict};
use trueaxis_effects::{Effect, Layer, Level, Scene};

use crate::diagnose::layout::labelled;
use crate::diagnose::{causes, in_words};

/// A group whose misfit is so much larger than that of all is worth its name.
const STANDS_OUT: f64 = 1.15;

/// Of an axis that does not move, µm: the prediction is sure but for rounding.
const ROUNDING_UM: f64 = 1e-6;

/// Groups that are named.
const MOST_PLACES: usize = 2;

/// All lines, without notices.
pub(crate) fn lines(diagnosis: &Diagnosis) -> Vec<String> {
    let mut lines = vec![format!("{}: {}", diagnosis.campaign, verdict(diagnosis))];
    for level in &diagnosis.levels {
        lines.extend(off(level));
    }
    let misfits: Vec<&Cause> = of_misfit(diagnosis).collect();
    for (k, cause) in misfits.iter().enumerate() {
        lines.push(String::new());
        let rank = (misfits.len() > 1).then_some(k + 1);
        // The calibration was done again without all causes together: told once.
        let first = k == 0 || misfits[k - 1].data != cause.data;
        lines.extend(causes::of_misfit(cause, rank, first, &diagnosis.scene));
        let is_last = |level: &&LevelReport| {
            let mut later = misfits[k + 1..].iter();
            cause.data.contains(&level.data) && later.all(|c| !c.data.contains(&level.data))
        };
        let of_several = cause.data.len() > 1;
        let levels = diagnosis.levels.iter().filter(is_last);
        lines.extend(levels.flat_map(|level| causes::gained(level, of_several)));
    }
    for disturbance in &diagnosis.disturbances {
        lines.extend(wanders(disturbance, &diagnosis.scene));
    }
    for level in &diagnosis.levels {
        let unexplained = level.unexplained.iter();
        lines.extend(unexplained.flat_map(|left| self::left(left, level)));
    }
    let of_curves = diagnosis.causes.iter().filter(|cause| !is_of_misfit(cause));
    let of_curves = of_curves.map(|cause| causes::of_curve(cause, &diagnosis.scene));
    let of_curves: Vec<String> = of_curves.collect();
    if !of_curves.is_empty() {
        lines.push(String::new());
        lines.push("what the error curves consist of (no fault of the model):".to_owned());
        lines.extend(of_curves);
    }
    lines.extend(not_observable(diagnosis));
    lines
}

/// Whether it contradicts the model: the form of an error curve does not.
fn is_of_misfit(cause: &&Cause) -> bool {
    cause.level != Level::Components
}

fn of_misfit(diagnosis: &Diagnosis) -> impl Iterator<Item = &Cause> {
    diagnosis.causes.iter().filter(is_of_misfit)
}

/// What no cause explains of a level.
fn left(unexplained: &Unexplained, level: &LevelReport) -> Vec<String> {
    let rms_um = in_words::amount(unexplained.rms_um, 2);
    let data = &unexplained.data;
    let is_scatter = unexplained.is_scatter(&level.before);
    let headline = match is_scatter {
        true => format!("repeats scatter in {data}: {rms_um} µm rms more than noise alone"),
        false if unexplained.varies_with == ["reading"] => {
            format!("doubtful in {data}: {rms_um} µm rms in single readings")
        }
        false => format!(
            "unexplained in {data}: {rms_um} µm rms, {} of the misfit in squares",
            in_words::percent(unexplained.share)
        ),
    };
    let mut lines = vec![String::new(), headline];
    lines.extend(labelled("what", &unexplained.note));
    let to_do = match is_scatter {
        true => {
            "see what differs from one repeat to the next (time to settle, clamping, cables, optics or targets that move) and repeat: a mean of \
             the repeats is only as certain as this scatter lets it be"
        }
        false => unexplained
            .action
            .unwrap_or_else(|| to_do(&unexplained.varies_with)),
    };
    lines.extend(labelled("to do", to_do));
    lines
}

/// What moves in a course that no known cause has.
fn wanders(disturbance: &Disturbance, scene: &Scene) -> Vec<String> {
    let length = disturbance.correlation_length;
    let mut lines = vec![
        String::new(),
        format!(
            "wanders: {}: {} µm rms, {} of the misfit in squares",
            disturbance.whose.in_words(scene),
            in_words::amount(disturbance.rms_um, 2),
            in_words::percent(disturbance.share)
        ),
    ];
    lines.extend(labelled("seen in", &disturbance.data));
    let how = match disturbance.period {
        Some(period) => format!(
            "swings with a period of {}",
            in_words::extent(period, length.unit)
        ),
        None => format!(
            "smooth over {}",
            in_words::extent(length.value, length.unit)
        ),
    };
    let how = format!("{how}; its curve is in diagnosis.json");
    lines.extend(labelled("how", &how));
    let rivals = disturbance.rivals.iter().map(|rival| rival.in_words(scene));
    let rivals: Vec<String> = rivals.collect();
    if !rivals.is_empty() {
        lines.extend(labelled("or", &rivals.join("; ")));
    }
    let whose = &disturbance.whose;
    let to_do = match (whose.layer, whose.subject.axis, whose.varies_with) {
        (Layer::Machine, Some(_), ["time"]) => {
            "log the temperature of the axis and of its scale: what grows and shrinks with time is mostly warm"
        }
        (Layer::Machine, Some(_), ["time", "position"]) => {
            "warm the machine up before measuring, and log the temperature of the bed and of the guides of the axis: squareness, \
             straightness and tilts that change with time are mostly warm"
        }
        (Layer::Machine, Some(_), ["direction"]) => {
            "look at the guides and bearings of the axis (clearance, preload, a drive beside the middle): it leans to one side as it is \
             pushed and to the other as it is pulled; `calibrate --by-direction` gives a curve for each side"
        }
        (Layer::Machine, Some(_), ["time", "direction"]) => {
            "look at the drive of the axis: what it loses changes while nut, bearings and clamps warm up or work loose"
        }
        (.., varies_with) => to_do(varies_with),
    };
    lines.extend(labelled("to do", to_do));
    lines
}

/// Where to look for what varies with something.
fn to_do(varies_with: &[&str]) -> &'static str {
    let has = |what: &str| varies_with.contains(&what);
    // What goes with time is looked for around the machine, what goes with the side or the place in it.
    if has("reading") {
        "see how these readings were taken and written down (too early, another target, digits, sign), correct or leave them out, \
         and diagnose the rest"
    } else if has("time") || has("cycle") || varies_with.is_empty() {
        "look for what changes like this (a warm-up, air conditioning, neighbours, the instrument's mount, the floor) \
         before the calibration is used"
    } else if has("reversal") {
        "look at how the axes turn round: stiction, the servos' gains and friction compensation; run the circle again at a \
         lower feed"
    } else if has("direction") {
        "look at the drive of the axis and at how the control stops: what differs between the sides of \
         approach is in neither the air nor the floor"
    } else {
        "look at what the axis passes on its way (guideway, screw, cable chain), and at how targets and \
         machine are clamped"
    }
}

fn verdict(diagnosis: &Diagnosis) -> String {
    let count = of_misfit(diagnosis).count();
    let is_clear = |cause: &&Cause| cause.rivals.is_empty();
    let clear = of_misfit(diagnosis).filter(is_clear).count();
    let is_left = diagnosis.levels.iter().any(|l| l.unexplained.is_some());
    let of_causes = diagnosis.causes.iter().filter_map(|cause| cause.share);
    let largest = of_causes.fold(0.0, f64::max);
    let more = if diagnosis.disturbances.iter().any(|d| d.share > largest) {
        ", but something that wanders explains more of the misfit"
    } else if is_left || !diagnosis.disturbances.is_empty() {
        ", and something more"
    } else {
        ""
    };
    match diagnosis.verdict {
        Verdict::NotJudged => "nothing was judged".to_owned(),
        Verdict::Clean => "clean, nothing contradicts the model".to_owned(),
        Verdict::Named if count > 1 => {
            let which = match clear {
                1 => format!("one of {count} causes is clear"),
                _ if clear < count => format!("{clear} of {count} causes are clear"),
                _ => format!("{count} causes are clear"),
            };
            format!("the data contradict the model, and {which}{more}")
        }
        Verdict::Named => format!("the data contradict the model, and the cause is clear{more}"),
        Verdict::Ambiguous if of_misfit(diagnosis).all(causes::is_clear_but_for_its_form) => {
            format!("the data contradict the model, and the cause is clear but for its form{more}")
        }
        Verdict::Ambiguous => {
            format!("the data contradict the model, and several causes are possible{more}")
        }
        Verdict::Unknown => {
            "the data contradict the model, and no known cause explains it".to_owned()
        }
    }
}

/// How far the prediction is off, and where.
fn off(level: &LevelReport) -> Vec<String> {
    // What is not explained may be in the scatter of the repeats, too.
    let floor = match level.unexplained {
        None => "noise alone is",
        Some(_) => "repeats scatter by",
    };
    let mut text = format!(
        "{} µm rms, {floor} {} µm",
        in_words::amount(level.before.rms_um, 2),
        in_words::amount(level.noise_floor_um, 2)
    );
    if let Some(u_um) = level.prediction_u_um.filter(|&u_um| u_um > ROUNDING_UM) {
        let u_um = in_words::amount(u_um, 2);
        text += &format!(", and the prediction is uncertain by {u_um} µm (u, rms)");
    }
    let shares = &level.shares;
    let found = match (shares.causes.is_empty(), shares.disturbances.is_empty()) {
        (false, true) => "the causes",
        (true, false) => "what wanders",
        _ => "all that was found",
    };
    if level.unexplained.is_some() || !shares.causes.is_empty() || !shares.disturbances.is_empty() {
        if level.after.rms_um < level.before.rms_um {
            let left = in_words::amount(level.after.rms_um, 2);
            text += &format!("; with {found} {left} µm");
        }
        let places = standing_out(level);
        if !places.is_empty() {
            text += &format!("; worst for {}", places.join(" and "));
        }
    }
    labelled("misfit", &format!("{}: {text}", level.data))
}

/// Where the misfit is largest: the worst group of each kind, if it is far worse than all.
fn standing_out(level: &LevelReport) -> Vec<String> {
    let mut worst: Vec<&Place> = Vec::new();
    for place in &level.places {
        match worst.iter_mut().find(|other| other.by == place.by) {
            Some(other) if place.before_um > other.before_um => *other = place,
            Some(_) => {}
            None => worst.push(place),
        }
    }
    worst.retain(|place| place.before_um > STANDS_OUT * level.before.rms_um);
    worst.sort_by(|a, b| b.before_um.total_cmp(&a.before_um));
    let described = worst.iter().take(MOST_PLACES).map(|place| {
        let what = match place.by {
            "position" => "axis ".to_owned(),
            by => format!("{by} "),
        };
        format!("{what}{} ({:.2} µm)", place.name, place.before_um)
    });
    described.collect()
}

/// One line of names.
fn not_observable(diagnosis: &Diagnosis) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for unseen in &diagnosis.not_observable {
        let name = unseen.effect.replace('_', " ");
        // Waves of an angle have names of their own.
        let is_it = |effect: &Effect| {
            effect.id == unseen.effect
                || unseen.effect == "cyclic_error" && effect.waves(1.0).is_some()
        };
        let mut causes = diagnosis.causes.iter();
        let name = match causes.any(|cause| is_it(cause.effect.effect)) {
            true => format!("{name} beside what is named"),
            false => name,
        };
        if !names.contains(&name) {
            names.push(name);
        }
    }
    if names.is_empty() {
        return Vec::new();
    }
    vec![
        String::new(),
        format!(
            "  not visible in these data, so not ruled out (diagnosis.json says why): {}",
            names.join(", ")
        ),
    ]
}
