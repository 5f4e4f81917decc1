"""Curves of contact that no single flank parameter describes."""
