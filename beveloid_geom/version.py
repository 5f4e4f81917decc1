"""Version of the package, which pyproject.toml reads here: frozen programs and zip files have no metadata."""

__version__ = "0.1.0"
