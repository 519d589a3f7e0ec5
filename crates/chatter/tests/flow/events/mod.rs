//! Events are found, at their time, and each once.

mod narrow_bumps;
mod nothing_passed_over;
mod resets;
mod sections;
mod singular_points;
mod undefined;
