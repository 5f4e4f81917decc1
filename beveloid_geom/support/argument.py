"""Faults of single arguments, with the argument as a field."""

from __future__ import annotations


class ArgumentError(ValueError):
    """A value outside its limits: the message is the `argument` and what it must be, `text`."""

    def __init__(self, argument: str, text: str) -> None:
        """Take the argument's name and the rest of the line."""
        self.argument, self.text = argument, text
        super().__init__(argument, text)

    def __str__(self) -> str:
        return f"{self.argument} {self.text}"
