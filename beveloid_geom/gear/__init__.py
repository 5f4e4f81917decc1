"""Geometry of one gear: rack, generated flank, fillet, undercut."""
