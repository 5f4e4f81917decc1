"""Contact of a pair as it is."""
