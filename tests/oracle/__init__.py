"""Table 1 by hand, a rack swept by numbers, and the reference equations held against one another."""
