"""Contact of a pair with given errors."""
