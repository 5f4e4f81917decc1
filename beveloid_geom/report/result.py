"""What every command that prints a result prints: one protocol, and its JSON, CSV and text.

A result is a dataclass with four members, whatever was computed. From `data` follow the JSON and the page's
numbers, from `rows` the CSV, with units from `columns`; `summary` is the text; `failure` the exit status.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping
from typing import Any, Protocol, TypeAlias

import numpy as np

from .columns import header_of

Rows: TypeAlias = Mapping[str, Any]
"""Columns (n,) of a table by their names, which `columns` knows; an array (n, 3) is a vector."""


class Result(Protocol):
    """What a command prints."""

    @property
    def failure(self) -> str | None:
        """Why the exit status is 1, as a line; None for status 0."""

    def data(self) -> Any:
        """Give what JSON and page have: dicts, lists, arrays; mm and rad; NaN for what is not known."""

    def rows(self) -> Rows:
        """Give what CSV has, in mm and rad."""

    def summary(self) -> str:
        """Give the text: mm, deg and arc seconds, at most 100 characters wide, what matters most last."""


def strict(value: Any) -> Any:
    """Make plain what JSON is to hold: lists of arrays, None for every number that is not finite."""
    if isinstance(value, dict):
        return {key: strict(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [strict(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return strict(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def json_text(data: Any) -> str:
    """Write one line of strict JSON."""
    return json.dumps(strict(data), allow_nan=False) + "\n"


def table_of(rows: Rows) -> tuple[list[str], list[list[Any]]]:
    """Give headers with units, and columns as lists: a vector takes three."""
    header: list[str] = []
    columns: list[list[Any]] = []
    for name, values in rows.items():
        listed = values.T.tolist() if isinstance(values, np.ndarray) else list(values)
        if np.ndim(values) > 1:
            header += [header_of(name, axis) for axis in "xyz"]
            columns += listed
        else:
            header.append(header_of(name))
            columns.append(listed)
    return header, columns


def csv_text(rows: Rows) -> str:
    """Write CSV, units in the header; the cell of what is not known stays empty."""
    text, (header, columns) = io.StringIO(), table_of(rows)
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    for row in zip(*columns, strict=True):
        writer.writerow("" if isinstance(value, float) and math.isnan(value) else value for value in row)
    return text.getvalue()


def by_columns(names: tuple[str, ...], rows: list[tuple[Any, ...]]) -> Rows:
    """Give rows of cells as named columns; without rows the columns are empty."""
    return dict(zip(names, zip(*rows, strict=True) if rows else [()] * len(names), strict=True))
