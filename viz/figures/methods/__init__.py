"""Figures of how the methods do."""
