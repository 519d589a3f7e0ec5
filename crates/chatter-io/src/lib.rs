//! Tables and figures as plain values, and their writers. Knows nothing of analyses.
