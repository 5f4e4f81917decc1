"""The mounted pair: frames, mounting, layouts without backlash, assembly errors."""
