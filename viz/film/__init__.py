"""Films of the pair in mesh, frame by frame, as GIF or MP4."""
