//! Six component errors of a machine tool axis from three measured points.
