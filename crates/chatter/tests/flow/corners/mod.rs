//! Equations that change their form: surfaces, sliding, tables.

mod asked;
mod jumps;
mod piecewise;
mod roots;
mod table_ends;
mod tables;
