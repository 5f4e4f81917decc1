"""Results in words: tables, JSON, CSV."""
