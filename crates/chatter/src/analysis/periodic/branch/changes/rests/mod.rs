//! Contacts at rest that are about to open, and those that have just opened.

mod beside;
mod flights;
mod opening;
mod released;
