"""Pairs written down, proposed, judged."""
