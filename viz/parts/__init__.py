"""Pieces of pictures that several figures share."""
