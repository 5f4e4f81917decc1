"""Search of the minimum clearance of tooth pairs: scan, starting points, local search."""
