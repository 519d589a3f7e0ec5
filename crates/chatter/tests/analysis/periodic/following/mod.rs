//! Branches are the same wherever they begin, whatever the steps, and however often they are broken off.

mod any_start;
mod beside_borders;
mod beside_folds;
mod cut_short;
mod doubled;
mod elastic;
mod families;
mod knots;
mod monitors;
mod rest_begins;
mod restitutions;
mod resumed;
mod shrinking;
mod stations;
mod steps;
mod sticks_together;
mod strikes;
mod together;
mod told_from;
mod told_once;
