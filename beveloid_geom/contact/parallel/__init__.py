"""Contact on parallel and nearly parallel axes: contact lines, and points that move along the face."""
