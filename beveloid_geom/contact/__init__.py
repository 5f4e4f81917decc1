"""Where two flanks are tangent: the path of contact and its ends."""
