//! The hybrid flow: flight, impact, chatter, sticking, release.
