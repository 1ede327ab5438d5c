//! Correct campaigns are read, damaged ones are refused with a message that says where the damage
//! is and how to correct it.

mod bed;
mod correct;
mod declared;
mod documents;
mod fixture;
mod geometries;
mod implausible;
mod rows;
mod units;
