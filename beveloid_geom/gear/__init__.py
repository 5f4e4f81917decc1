"""One gear: rack, generated flank, fillet, the whole side of a tooth."""
