"""Design files, proposals, checks."""
