//! A campaign with fewer steps, so that many mistakes can be tried.

use trueaxis_campaign::Campaign;

use crate::mistakes::scope::with_lengths;

/// Steps that are left of each run: enough to tell a line or a circle from what is none.
const STEPS: usize = 9;

/// The campaign with steps evenly taken from each run, ends included, and with the targets on the bed.
pub(crate) fn thinned(campaign: &Campaign) -> Campaign {
    let mut kept: Vec<bool> = campaign
        .steps
        .iter()
        .map(|step| step.run.is_none())
        .collect();
    for run in 0..campaign.runs.len() {
        let is_of_run = |step: &usize| campaign.steps[*step].run == Some(run);
        let of_run = (0..campaign.steps.len()).filter(is_of_run);
        let of_run: Vec<usize> = of_run.collect();
        let last = of_run.len().saturating_sub(1);
        for i in 0..STEPS.min(of_run.len()) {
            kept[of_run[i * last / (STEPS.min(of_run.len()) - 1).max(1)]] = true;
        }
    }
    with_lengths(campaign, |stop, _| kept[stop.step])
}
