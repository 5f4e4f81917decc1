"""Contact by proximity of two flank meshes, polished on the exact flanks."""
