"""Errors of single arguments, with the name of the argument as a field."""

from __future__ import annotations


class ArgumentError(ValueError):
    """Value outside its limits. The message is the name of the `argument`, followed by its limits, `text`."""

    def __init__(self, argument: str, text: str) -> None:
        """Store the name of the argument and the remaining text of the message."""
        self.argument, self.text = argument, text
        super().__init__(argument, text)

    def __str__(self) -> str:
        return f"{self.argument} {self.text}"
