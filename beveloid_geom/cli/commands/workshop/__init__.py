"""For drawings, measuring, mounting and other programs."""
