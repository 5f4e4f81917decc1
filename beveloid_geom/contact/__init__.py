"""Contact of two flanks: path of contact, contact ratio, contact ellipse, Hertz pressure."""
