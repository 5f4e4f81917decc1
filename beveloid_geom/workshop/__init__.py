"""Manufacturing and measurement: tooth dimensions, balls, spans, measuring grids, shims."""
