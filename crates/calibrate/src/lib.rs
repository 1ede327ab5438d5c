//! All geometric errors of a machine tool from a measuring campaign.
