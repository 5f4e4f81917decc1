"""Reports for drawing, measurement and assembly."""
