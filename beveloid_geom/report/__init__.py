"""Reports of results: text, JSON, CSV."""
