//! Impacting systems: states, parameters, contacts, sections, and the files that hold them.
