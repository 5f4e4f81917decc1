"""Table 1 by hand, a numerical sweep of the rack, and comparisons of the reference equations with each
other."""
