//! Expression graphs, their parser, derivatives and tapes.
