//! The passes of the adjustment with free points.
//!
//! [`Arch::dispatch`] compiles the loops over groups once more for wider registers and takes the widest
//! that the processor has.

use nalgebra::Vector3;
use pulp::Arch;
use trueaxis_leastsquares::{Adjustment, Error as LeastSquaresError, Factors, Reduced};

use crate::free_points::{DATUM, FreePoints, State};
use crate::group_equations::GroupMemory;
use crate::passes::{in_parallel, pieces, split_points, sum_pieces};

impl Adjustment for FreePoints<'_> {
    type State = State;

    fn reduce(&self, state: &State) -> Result<Reduced, LeastSquaresError> {
        let groups = self.network().groups.len();
        let sum = sum_pieces(groups, |piece| {
            if let Some(single) = self.single() {
                return single.reduce(self, state, piece);
            }
            Arch::new().dispatch(
                #[inline(always)]
                || {
                    let mut memory = GroupMemory::new(self);
                    let mut reduced = Reduced::new(self.shared(), DATUM);
                    for group in piece {
                        self.eliminate_group(state, group, &mut memory)?;
                        self.reduce_group(group, &memory, &mut reduced);
                    }
                    Ok(reduced)
                },
            )
        })?;
        Ok(sum.unwrap_or_else(|| Reduced::new(self.shared(), DATUM)))
    }

    fn step(
        &self,
        state: &State,
        t: &[f64],
        factor: f64,
        next: &mut State,
    ) -> Result<(), LeastSquaresError> {
        self.step_stations(state, t, factor, next);
        let groups = &self.network().groups;
        let pieces = pieces(groups.len());
        let moved = split_points(&pieces, groups, &mut next.points);
        let work = pieces.into_iter().zip(moved).collect();
        in_parallel(work, |(piece, moved)| {
            if let Some(single) = self.single() {
                return single.step(self, state, (t, factor), piece, moved);
            }
            Arch::new().dispatch(
                #[inline(always)]
                || {
                    let mut memory = GroupMemory::new(self);
                    let mut x = Vec::new();
                    let first = groups[piece.start].start;
                    for group in piece {
                        self.correct_group(state, group, t, &mut memory, &mut x)?;
                        let points = groups[group].clone();
                        let moved = &mut moved[points.start - first..points.end - first];
                        let points = state.points[points].iter().zip(x.chunks_exact(3));
                        for (moved, (point, x)) in moved.iter_mut().zip(points) {
                            *moved = point + Vector3::from_column_slice(x) * factor;
                        }
                    }
                    Ok(())
                },
            )
        })?;
        Ok(())
    }

    fn factors(&self, state: &State) -> Result<Factors, LeastSquaresError> {
        let groups = &self.network().groups;
        let unknowns = groups.iter().map(|group| 3 * group.len());
        let mut factors = Factors::zeros(self.shared() + DATUM, unknowns);
        let pieces = pieces(groups.len());
        let parts = factors.split_mut(&pieces);
        let work = pieces.iter().cloned().zip(parts).collect();
        in_parallel(work, |(piece, mut part)| {
            if let Some(single) = self.single() {
                return single.factors(self, state, piece, &mut part);
            }
            Arch::new().dispatch(
                #[inline(always)]
                || {
                    let mut memory = GroupMemory::new(self);
                    for group in piece {
                        self.eliminate_group(state, group, &mut memory)?;
                        part.set(group, &memory.block);
                    }
                    Ok(())
                },
            )
        })?;
        Ok(factors)
    }

    fn free_motions(&self, state: &State) -> Vec<Vec<f64>> {
        self.free_motions_of(state, self.shared())
    }
}

#[cfg(test)]
mod tests;
