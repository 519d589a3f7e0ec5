//! Numbers, truncated series and polynomials. Knows nothing of models.
