//! The records at each position of an axis.

use crate::identify::axis_data::AxisData;

/// The records of every node.
pub(crate) struct NodeRecords {
    /// Where those of each node start, and behind them their number.
    starts: Vec<usize>,
    records: Vec<usize>,
}

impl NodeRecords {
    pub(crate) fn new(axis: &AxisData) -> Self {
        let mut records: Vec<usize> = (0..axis.records.len()).collect();
        records.sort_by_key(|&i| axis.records[i].node);
        let mut starts = vec![0];
        for node in &axis.nodes {
            starts.push(starts[starts.len() - 1] + node.records);
        }
        Self { starts, records }
    }

    /// Those of a node, in the order of measuring.
    pub(crate) fn of(&self, node: usize) -> &[usize] {
        &self.records[self.starts[node]..self.starts[node + 1]]
    }
}
