"""Reports of optimised parabola coefficients and amounts of modification."""
