"""Contact of flanks that are given as surfaces, with modifications."""
