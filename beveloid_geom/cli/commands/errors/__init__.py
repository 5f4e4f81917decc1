"""Contact under errors, and over values of a design."""
