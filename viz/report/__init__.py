"""Report page of a design for the browser (`render-report`)."""
