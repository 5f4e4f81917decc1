"""What a workshop and a measuring room take: dimensions of a tooth, balls, grids of points, shims."""
