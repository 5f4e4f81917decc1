"""Remarks on designs: errors, warnings, notes, advice."""
