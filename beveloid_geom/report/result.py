"""Base class of the reports of commands, and their output as JSON and CSV.

A report provides `values` (the entries of JSON), `rows` (the columns of CSV) and `summary` (the text). The
JSON begins with the layout and ends with the reason of a missing result; units of CSV columns are those of
`columns`.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from enum import IntEnum
from typing import Any, ClassVar, Generic, NamedTuple, Protocol, TypeAlias, TypeVar

import numpy as np

from ..arrays import FLANK_SIGN, MEMBERS as MEMBERS
from ..contact.path import PathEnds
from ..design.member import MODIFICATIONS
from ..design.model import Design
from ..findings.advice import Advice
from ..findings.backlash import backlash_data, backlash_report
from ..pair.misalignment_at_mesh import at_mesh, pivot_distance
from ..pair.mounting import mounting_of
from ..status import CODES_OF_FIELDS, NotComputed, Status
from ..support.process import NO_CONTACT, NOT_COMPUTED
from .columns import header_of

Rows: TypeAlias = Mapping[str, Any]
"""Columns (n,) of a table by name; an array (n, 3) is a vector, a single value belongs to all rows."""


class Failure(NamedTuple):
    """Message on standard error and exit status of a command without a result or with a pair that jams."""

    text: str
    status: int = NO_CONTACT


class Result(Protocol):
    """Interface of the results that commands print."""

    @property
    def failure(self) -> Failure | None:
        """Failure of the command, None for exit status 0."""

    def data(self) -> Any:
        """Return the content of JSON and page: dicts, lists, arrays; mm and rad; NaN for unknown numbers."""

    def rows(self) -> Rows:
        """Return the columns of CSV, mm and rad."""

    def summary(self) -> str:
        """Return the text: mm, deg and arcsec, at most 100 characters wide, the conclusions last."""


@dataclass(frozen=True, eq=False)
class Report:
    """Base class of reports on a single design.

    Subclasses are frozen dataclasses, with `flank` if the result belongs to one flank pair, and with `reason`
    if the result can be missing."""

    name: str
    design: Design
    needs_assembly: ClassVar[bool] = False
    """Whether a pair that cannot be assembled is a failure."""

    @property
    def failure(self) -> Failure | None:
        """Failure if there is no result, or if `needs_assembly` and the pair cannot be assembled."""
        return failure_of(getattr(self, "reason", None), self.design if self.needs_assembly else None)

    def values(self) -> dict[str, Any]:
        """Return the entries of JSON other than the layout and the reason, mm and rad. They may contain
        dataclasses and codes, which `plain` converts."""
        raise NotImplementedError

    def data(self) -> Any:
        """Return the content of JSON: layout, values, and the reason if the result is missing."""
        flank, reason = getattr(self, "flank", None), getattr(self, "reason", None)
        head = layout_data(self.name, self.design)
        if flank is not None:
            head = {"flank": flank, **head, **parabola_data(self.design, flank)}
        head |= modification_data(self.design)
        return plain(head | self.values() | ({"reason": reason} if reason else {}))


class OnFlank(Protocol):
    """Result of a function that stores its flank."""

    @property
    def flank(self) -> str:
        """Driving flanks."""


ResultT = TypeVar("ResultT", bound=OnFlank)


@dataclass(frozen=True, eq=False)
class ResultReport(Report, Generic[ResultT]):
    """Report on a single `result` that stores its flank."""

    result: ResultT

    @property
    def flank(self) -> str:
        """Driving flanks."""
        return self.result.flank


def failure_of(reason: str | None, design: Design | None = None) -> Failure | None:
    """Return the failure for the reason of a missing result, or for a design that jams, otherwise None.

    A reason of the type `NotComputed` has exit status 4, all others 1."""
    if isinstance(reason, NotComputed):
        return Failure(f"Not computed: {reason}", NOT_COMPUTED)
    if reason:
        return Failure(f"No contact: {reason}")
    jam = None if design is None else backlash_report(design).jam
    return Failure(f"Jammed: {jam}") if jam else None


def name_in_files(code: IntEnum) -> str:
    """Return the name of a status or limit in JSON and CSV: lower case with underscores."""
    return code.name.lower()


def status_name(code: int) -> str:
    """Return the name of a `Status` in JSON and CSV."""
    return name_in_files(Status(int(code)))


def ends_data(ends: PathEnds) -> dict[str, Any]:
    """Return the limits at both ends of a path for JSON, None for a missing end."""
    both = {"enter": ends.enter, "leave": ends.leave}
    return {k: None if end is None else {"member": end.member, "limit": end.limit} for k, end in both.items()}


def layout_data(name: str, design: Design) -> dict[str, Any]:
    """Return the entries of JSON on the layout of a single design, mm and rad."""
    mounting = mounting_of(design)
    values = (*mounting.distance, *mounting.working_radius, mounting.pitch_point)
    return {
        "design": name,
        "layout": {
            "offset": design.pair.offset,
            "shaft_angle": design.pair.shaft_angle,
            "errors": design.errors,
            "errors_at": design.errors_at,
            "errors_at_mesh": at_mesh(design),
            "pivot_distance": pivot_distance(design),
        },
        "mounting": dict(zip(("dw1", "dw2", "rw1", "rw2", "pitch_point"), values, strict=True)),
        "normal_backlash": mounting.normal_backlash,
        **backlash_data(design),
    }


def parabola_data(design: Design, flank: str) -> dict[str, dict[str, Any]]:
    """Return the entries of JSON on the parabolas of a flank by member: coefficients (1/mm), apexes (mm)."""
    tools = {name: getattr(design, name).tool for name in MEMBERS}
    return {
        "parabola": {name: tool.parabola_of(flank) for name, tool in tools.items()},
        "parabola_apex": {name: tool.parabola_apex for name, tool in tools.items()},
    }


def modification_data(design: Design) -> dict[str, Any]:
    """Return the entry of JSON on modifications by member and flank, um and mm; empty if there are none."""
    given = {
        name: {
            flank: one.given()
            for flank, field in MODIFICATIONS.items()
            if (one := getattr(getattr(design, name), field)) is not None
            and (not one.empty or one.pitch_deviations_um is not None)
        }
        for name in MEMBERS
    }
    return {"modification": given} if any(given.values()) else {}


def advice_data(advice: Sequence[Advice]) -> list[dict[str, Any]]:
    """Return each proposed change for JSON: its values, mm and rad, and its text."""
    return [plain(change) | {"text": change.words()} for change in advice]


def strict(value: Any) -> Any:
    """Return a value for strict JSON: lists for arrays, None for numbers that are not finite."""
    return _listed(value, lambda item: None if isinstance(item, float) and not math.isfinite(item) else item)


def json_text(data: Any) -> str:
    """Return one line of strict JSON."""
    return json.dumps(strict(data), allow_nan=False) + "\n"


def to_dict(result: Any) -> Any:
    """Return a result as nested dictionaries, lists and numbers.

    Parameters
    ----------
    result : dataclass
        Any input or result of the library, such as a `Design` or a `ContactPath`.

    Returns
    -------
    dict
        Fields by name, mm and rad. Arrays are lists, NaN stays NaN, and codes are replaced by the names of
        their enumeration (`Status`, `Limit`, ...); a code of -1 is None.

    Examples
    --------
    >>> from beveloid_geom import builtin_design, path_of_contact, to_dict
    >>> to_dict(path_of_contact(builtin_design(), points=2))["status"]
    ['solved', 'solved']
    """
    return _listed(plain(result), lambda item: item)


def plain(value: Any, codes: type[IntEnum] | None = None) -> Any:
    """Return dataclasses in a value as dictionaries and codes as names; arrays remain arrays.

    `codes` is the enumeration of a value that consists of codes; a code of -1 becomes None."""
    if codes is not None:
        names: dict[int, str | None] = {int(code): name_in_files(code) for code in codes}
        return _listed(value, names.get)
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        return picked(value, *(field.name for field in fields(value)))
    return name_in_files(value) if isinstance(value, IntEnum) else value


def picked(result: Any, *names: str) -> dict[str, Any]:
    """Return fields of a result by name, as `plain` does, with the names of codes."""
    kind = type(result).__name__
    return {name: plain(getattr(result, name), CODES_OF_FIELDS.get(f"{kind}.{name}")) for name in names}


def _listed(nested: Any, function: Callable[[Any], Any]) -> Any:
    """Return nested values as dictionaries and lists, with a function applied to each number or text."""
    if isinstance(nested, np.ndarray | np.generic):
        return _listed(nested.tolist(), function)
    if isinstance(nested, dict):
        return {key: _listed(item, function) for key, item in nested.items()}
    if isinstance(nested, list | tuple):
        return [_listed(item, function) for item in nested]
    return function(nested)


def to_csv(result: Any) -> str:
    """Return the arrays of a result as CSV, one row for each position or case.

    Parameters
    ----------
    result : dataclass
        Result with arrays, such as a `ContactPath`.

    Returns
    -------
    str
        The columns are the arrays with the most frequent length of the first axis. Their names contain the
        unit; a vector has three columns. Codes are replaced by names; NaN is an empty cell. A `FlankGrid` and
        a `ContactPattern` have a row for each point of their grids, and `ToothData` for each change of the
        thickness and each plane.

    Raises
    ------
    ValueError
        If the result has no arrays, or for triangles and hexahedra, which `write` writes.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> text = bg.to_csv(bg.path_of_contact(bg.builtin_design("ni-2017"), points=2))
    >>> text.splitlines()[0].split(",")[:4]
    ['l1_mm', 'u1_mm', 'l2_mm', 'u2_mm']
    """
    kind = type(result).__name__
    if hasattr(result, "faces") or hasattr(result, "hexahedra"):
        raise ValueError(f"{kind} is no table: use write(result, path), or to_dict(result)")
    if kind == "ToothData":
        return csv_text(stacked_rows([_planes(result, k) for k in range(len(result.change))]))
    if kind == "ContactPattern":
        return csv_text(stacked_rows([{"member": m} | _grid_rows(getattr(result, m)) for m in MEMBERS]))
    if kind in ("FlankGrid", "MemberPattern"):
        return csv_text(_grid_rows(result))
    data = to_dict(result)
    arrays = {name: value for name, value in vars(result).items() if np.ndim(value) in (1, 2) and len(value)}
    if not arrays:
        raise ValueError(f"{kind} has no arrays: use to_dict")
    lengths = [len(value) for value in arrays.values()]
    count = max(lengths, key=lengths.count)
    rows: dict[str, Any] = {}
    for name, values in arrays.items():
        if len(values) != count:
            continue
        columns = np.asarray(data[name], dtype=object)
        if columns.ndim == 1 or columns.shape[1] == 3:
            rows[name] = columns
        else:  # other second axes are numbered
            rows |= {f"{name}_{k}": columns[:, k] for k in range(columns.shape[1])}
    return csv_text(rows)


def _grid_rows(grid: Any) -> dict[str, Any]:
    """Return one row for each point of a grid; a station z belongs to all points of its column."""
    rows, shape = {}, grid.points.shape[:2]
    names = [name for name, value in vars(grid).items() if name != "border" and np.shape(value)]
    for name, given in picked(grid, *names).items():
        values = np.asarray(given)
        values = np.broadcast_to(values, shape) if values.ndim == 1 else values
        rows[name.removesuffix("s") if values.ndim == 3 else name] = values.reshape(-1, *values.shape[2:])
    return rows


def _planes(tooth: Any, k: int) -> dict[str, Any]:
    """Return one row for each plane, with change number k of the thickness; single values are repeated."""
    columns = {"change_of_thickness": tooth.change[k]}
    for name, value in vars(tooth).items():
        if name in ("form_diameter", "base_diameter"):
            columns |= {f"{flank}_{name}": row for flank, row in zip(FLANK_SIGN, value, strict=True)}
        elif name != "change":
            columns[name] = value[k] if np.ndim(value) == 2 else value
    return columns


def table_of(rows: Rows) -> tuple[list[str], list[list[Any]]]:
    """Return the headers with units and the columns as lists; a vector has three columns."""
    header: list[str] = []
    columns: list[list[Any]] = []
    count = max((len(values) for values in rows.values() if np.ndim(values)), default=1)
    for name, values in rows.items():
        if np.ndim(values) > 1:
            header += [header_of(name, axis) for axis in "xyz"]
            columns += np.asarray(values).T.tolist()
        else:
            header.append(header_of(name))
            columns.append(_cells(values, count))
    return header, columns


def _cells(values: Any, count: int) -> list[Any]:
    """Return a column as a list; a single value fills `count` rows."""
    if not np.ndim(values):
        return [values] * count
    return values.tolist() if isinstance(values, np.ndarray) else list(values)


def csv_text(rows: Rows) -> str:
    """Return CSV with units in the header, by `csv_of`."""
    header, columns = table_of(rows)
    return csv_of(header, zip(*columns, strict=True))


def csv_of(header: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """Return CSV; cells of unknown values are empty, false is 0 and true is 1."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(map(_csv_cell, row) for row in rows)
    return text.getvalue()


def _csv_cell(value: Any) -> Any:
    """Return the value that a cell of CSV has."""
    value = int(value) if isinstance(value, bool | np.bool_) else value
    return "" if isinstance(value, float) and math.isnan(value) else value


def by_columns(names: tuple[str, ...], rows: list[tuple[Any, ...]]) -> Rows:
    """Return rows of cells as named columns; without rows, the columns are empty."""
    return dict(zip(names, zip(*rows, strict=True) if rows else [()] * len(names), strict=True))


def stacked_rows(tables: Sequence[Rows], names: Sequence[str] = ()) -> dict[str, Any]:
    """Return tables with the same or similar columns one below the other; missing cells are empty.

    The columns begin with `names`. A table of single values is one row."""
    columns: dict[str, list[Any]] = {name: [] for name in (*names, *(n for table in tables for n in table))}
    for table in tables:
        count = max((len(values) for values in table.values() if np.ndim(values)), default=1)
        for name, column in columns.items():
            column += _cells(table.get(name, ""), count)
    return columns


def flattened(columns: Mapping[str, Any]) -> dict[str, Any]:
    """Return quantities on a grid as columns, in the order of the points."""
    return {name: np.ravel(values) for name, values in columns.items()}


def by_member(name: str, values: Any) -> dict[str, Any]:
    """Return a quantity (..., 2) of pinion and gear as two columns."""
    return {f"{member}_{name}": values[..., j] for j, member in enumerate(MEMBERS)}
