"""Contact on parallel and nearly parallel axes: lines, and points that run along the face."""
