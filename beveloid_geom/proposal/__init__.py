"""From a requirement to pairs that close."""
