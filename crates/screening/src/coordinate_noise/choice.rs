//! Which form the noise of coordinates has.

use nalgebra::{Point3, Vector3};
use trueaxis_leastsquares::chi_squared_upper_tail;

use crate::coordinate_noise::block::Block;
use crate::coordinate_noise::likelihood::Fitted;
use crate::coordinate_noise::{CoordinateNoise, StepReadings};

/// Significance from which noise is not equal.
const LEVEL: f64 = 1e-3;

/// Redundancy from which a variance is known well enough to weigh with: to 30 %.
const LEAST_REDUNDANCY: f64 = 20.0;

/// Most blocks that are compared, evenly over all: more only take time.
const MOST_BLOCKS: usize = 100;

/// Standard deviation of a coordinate below which it was computed, not measured, mm.
const LEAST_MM: f64 = 1e-7;

/// Visits whose mean squares exceed that of the best tenth by this factor hold something else than noise.
const NOT_NOISE: f64 = 25.0;
const BEST_ONE_IN: usize = 10;

/// Parameters beside that of equal noise: variances of three directions and their rotation; one ratio; the ratio and the
/// place of an instrument that is sought.
const OF_DIRECTIONS: f64 = 5.0;
const OF_POLAR: f64 = 1.0;
const OF_SOUGHT: f64 = 4.0;

/// How often directions are found again with the weights that they had.
const TURNS: usize = 3;

/// Distances at which the search for an instrument begins, mm.
const DISTANCES_MM: [f64; 3] = [1e3, 2.5e3, 6e3];

/// First and last step of the search: of the direction, and of the logarithm of the distance.
const FIRST_STEP: f64 = 0.2;
const LAST_STEP: f64 = 0.01;

/// Most moves: an instrument far away is like directions that are the same for all points, however far.
const MOST_MOVES: usize = 30;

impl CoordinateNoise {
    /// What the readings say; equal noise where they say nothing else.
    pub fn estimated(steps: &[StepReadings]) -> Self {
        let all: Vec<Block<'_>> = steps.iter().flat_map(Block::all_of).collect();
        let most = all.len().min(MOST_BLOCKS);
        let blocks: Vec<Block<'_>> = (0..most).map(|k| all[k * all.len() / most]).collect();
        let Some((kept, equal)) = without_mistakes(&blocks, &Self::EQUAL) else {
            return Self::EQUAL;
        };
        if equal.noise.variances[0] < LEAST_MM * LEAST_MM {
            return Self::EQUAL;
        }
        let found = likeliest(&kept, &equal).and_then(|found| {
            // By equal noise, points that are far away look like mistakes.
            let (again, _) = without_mistakes(&blocks, &found.noise)?;
            match again.len() > kept.len() {
                true => likeliest(&again, &Fitted::new(&again, Self::EQUAL)?),
                false => Some(found),
            }
        });
        let readings = steps.iter().flat_map(|step| &step.readings);
        let points_mm: Vec<Point3<f64>> = readings.map(|own| own.point_mm).collect();
        found.map_or(Self::EQUAL, |found| {
            found.expected().of_unit_mean(&points_mm)
        })
    }
}

/// The blocks that hold nothing but noise of this form. What is wrong bends the shapes of the bodies, and with these
/// everything else: the largest leave first.
fn without_mistakes<'a>(
    blocks: &[Block<'a>],
    noise: &CoordinateNoise,
) -> Option<(Vec<Block<'a>>, Fitted)> {
    let mut kept = blocks.to_vec();
    loop {
        let fitted = Fitted::new(&kept, noise.clone())?;
        let mut sorted = fitted.of_blocks.clone();
        sorted.retain(|mean| *mean > 0.0);
        sorted.sort_by(f64::total_cmp);
        let best = sorted.get(sorted.len() / BEST_ONE_IN);
        let limit = NOT_NOISE * best.copied().unwrap_or(0.0);
        let (count, mut of_blocks) = (kept.len(), fitted.of_blocks.iter());
        kept.retain(|_| of_blocks.next().is_some_and(|mean| *mean <= limit));
        if kept.len() == count {
            return Some((kept, fitted));
        }
    }
}

/// The likeliest noise that is not equal, if it is significantly likelier and its variances are known.
fn likeliest(blocks: &[Block<'_>], equal: &Fitted) -> Option<Fitted> {
    let readings = blocks.iter().flat_map(|block| block.readings);
    let points_mm: Vec<Point3<f64>> = readings.map(|own| own.point_mm).collect();
    // By how much its criterion is better than that of equal noise, if that is significant.
    let offered = |fitted: Option<Fitted>, parameters: f64| {
        let fitted = fitted?;
        let two_ln_l = fitted.two_ln_l - equal.two_ln_l;
        let is_significant = chi_squared_upper_tail(two_ln_l, parameters) < LEVEL;
        is_significant.then(|| (two_ln_l - parameters * equal.redundancy.ln(), fitted))
    };
    let fitted = |noise: CoordinateNoise| Fitted::new(blocks, noise);
    // With equal weights what is badly known leaks into the other directions.
    let mut directions = fitted(CoordinateNoise::directions(equal.principal));
    for _ in 0..TURNS {
        let turned = directions.map(|fitted| CoordinateNoise::directions(fitted.principal));
        directions = turned.and_then(fitted);
    }
    let directions = offered(directions, OF_DIRECTIONS);
    let sought = directions
        .as_ref()
        .and_then(|(_, fitted)| sought(blocks, &points_mm, fitted));
    let at_origin = CoordinateNoise::polar(Point3::origin(), &points_mm).and_then(fitted);
    let all = [
        directions,
        offered(at_origin, OF_POLAR),
        offered(sought, OF_SOUGHT),
    ];
    let best = all.into_iter().flatten().max_by(|a, b| a.0.total_cmp(&b.0));
    // Where the data do not tell the variances of the likeliest form, those of another one would be wrong.
    let (_, best) = best?;
    (best.least_redundancy() > LEAST_REDUNDANCY).then_some(best)
}

/// The instrument of the greatest likelihood, sought from both sides along the direction in which coordinates are best
/// known, by the moves of R. Hooke and T. A. Jeeves (*Journal of the ACM* 8, 212, 1961).
fn sought(blocks: &[Block<'_>], points_mm: &[Point3<f64>], directions: &Fitted) -> Option<Fitted> {
    let (rows, variances) = directions.noise.at(&Point3::origin());
    let least = Vector3::from(variances).imin();
    let across = (variances.iter().sum::<f64>() - variances[least]) / 2.0;
    let mut first = directions.clone();
    first.noise.variances = [variances[least], across, across];
    let turned = |k: usize| rows.row((least + k) % 3).transpose();
    let (beam, across, other) = (turned(0), turned(1), turned(2));
    let sum: Vector3<f64> = points_mm.iter().map(|point| point.coords).sum();
    let centroid_mm = Point3::from(sum / points_mm.len() as f64);
    // By the tangents of two angles and the logarithm of the distance, on one side.
    let at = |side: f64, place: &Vector3<f64>, near: &Fitted| {
        let direction = beam * side + across * place.x + other * place.y;
        let station_mm = centroid_mm + direction.normalize() * place.z.exp();
        let noise = CoordinateNoise::polar(station_mm, points_mm)?;
        Fitted::near(blocks, noise, near)
    };
    let starts = DISTANCES_MM.iter().flat_map(|mm| [(1.0, *mm), (-1.0, *mm)]);
    let starts = starts.filter_map(|(side, mm)| {
        let place = Vector3::new(0.0, 0.0, mm.ln());
        Some((side, place, at(side, &place, &first)?))
    });
    let start = starts.max_by(|a, b| a.2.two_ln_l.total_cmp(&b.2.two_ln_l));
    let (side, mut place, mut best) = start?;
    let explored = |mut place: Vector3<f64>, mut best: Fitted, step: f64| {
        for k in 0..3 {
            let moves = [step, -step].map(|step| place + Vector3::ith(k, step));
            let mut moved = moves
                .into_iter()
                .filter_map(|place| Some((place, at(side, &place, &best)?)));
            let better = moved.find(|(_, moved)| moved.two_ln_l > best.two_ln_l);
            if let Some(better) = better {
                (place, best) = better;
            }
        }
        (place, best)
    };
    let mut step = FIRST_STEP;
    for _ in 0..MOST_MOVES {
        if step < LAST_STEP {
            break;
        }
        let (next, of_next) = explored(place, best.clone(), step);
        if of_next.two_ln_l <= best.two_ln_l {
            step *= 0.5;
            continue;
        }
        // As far again, if that is better.
        let farther = next + (next - place);
        let of_farther = at(side, &farther, &of_next).map(|of| explored(farther, of, step));
        (place, best) = match of_farther {
            Some((place, of)) if of.two_ln_l > of_next.two_ln_l => (place, of),
            _ => (next, of_next),
        };
    }
    Fitted::new(blocks, best.noise)
}
