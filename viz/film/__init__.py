"""Film of the pair in mesh as GIF or MP4 (`render-animation`)."""
