//! The program as its users run it: commands, what they print and write, what ends them.

mod common;

#[cfg(unix)]
mod data_files;
mod diagrams;
mod documents;
#[cfg(unix)]
mod files;
#[cfg(unix)]
mod guards;
#[cfg(unix)]
mod periodic;
mod shards;
mod sweeps;
mod theory;
