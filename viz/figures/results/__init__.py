"""Figures of a design's results."""
