"""Outcome of each method in a situation, in a few words with fixed thresholds, so that they are the same on
all machines."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass

import numpy as np

from beveloid_geom import ContactPath, Design, Status, first_contact, path_certificate, path_of_contact
from beveloid_geom.findings.layout import remarks_on
from beveloid_geom.operation.engagement import pitch_point_roll
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.report.path import ContactReport, contact_report
from beveloid_geom.shapes.proximity.mesh_contact import mesh_contact
from beveloid_geom.status import FirstStatus, Verdict
from beveloid_geom.validation.five_equations import path_of_contact_five_equations

from .answers import SIZE, size_of
from .five_residuals import margins, residuals

POINTS = 5
EXACT, NORMALS = 1e-9, 1e-12
"""mm and rad: tolerances of the five equations."""
SAME_ENDS, SAME_RATIO = 1e-6, 1e-6
"""mm of l1, and of the contact ratio, within which two methods found the same path."""
NEAR, CERTAIN = 0.1, 1e-6
"""mm: largest distance of facets that are called near, and largest error estimate of a polished contact."""
METHODS = ("one equation", "five equations", "facets", "polished", "first contact")
WRONG = "wrong"

Said = Callable[[Design, str], Iterable[str]]


@dataclass(frozen=True)
class Case:
    """A design and flank. For the meshes also the pose: the position along the path as a `share` of l1
    (without a path, both rolls are 0), and the `tolerance`, mm."""

    design: Design
    flank: str = "right"
    share: float = 0.5
    tolerance: float = 0.01


@dataclass(frozen=True)
class Situation:
    """A row of the table.

    The `cases` are run. `trusted` are those of METHODS whose results are trusted ("status": there is no
    contact). `message` is the message to the user, empty if none is needed, and `texts` returns the texts
    that may contain it. `disturbed` is a context in which the meshes are evaluated, and `moved` (mm) the
    displacement of the pair by it."""

    name: str
    cases: Callable[[], Sequence[Case]]
    trusted: tuple[str, ...]
    message: str = ""
    texts: Said | None = None
    disturbed: Callable[[], AbstractContextManager[object]] = nullcontext
    moved: tuple[float, float, float] = (0.0, 0.0, 0.0)


def in_a_cell(names: Iterable[str]) -> str:
    """Return different outcomes, each once."""
    return ", ".join(dict.fromkeys(name for part in names for name in part.split(", ")))


def scale_of(design: Design) -> float:
    return size_of(design) / SIZE


def of_path(design: Design, path: ContactPath) -> str:
    """Return a status, or 'exact': every position is solved on both flanks and satisfies the five
    equations."""
    if not path.l1.size:
        return f"`{Status(int(path.ends.status)).name}`"
    if (path.status != Status.SOLVED).any():
        return "partly lost"
    apart, turned = residuals(design, path, mounting_of(design).distance)
    bound = EXACT * min(1.0, scale_of(design))
    true = apart.max() <= bound and turned.max() <= NORMALS
    return "exact" if true and margins(design, path).min() >= -1e-9 * max(1.0, scale_of(design)) else WRONG


def of_five(design: Design, ours: ContactPath, path: ContactPath) -> str:
    """Return the outcome of the five equations, and whether their path is that of the one equation."""
    word = of_path(design, path)
    if word != "exact" or not ours.l1.size:
        return word
    ends = np.abs(np.sort(ours.ends.l1) - np.sort(path.ends.l1)).max() <= SAME_ENDS * scale_of(design)
    ratio = abs(float(ours.ends.contact_ratio - path.ends.contact_ratio)) <= SAME_RATIO
    return word if ends and ratio else "another piece"


def attempted(method: Callable[[], str]) -> str:
    try:
        return method()
    except (ValueError, ArithmeticError):
        return "refused"


def of_meshes(case: Case, polish: bool, moved: tuple[float, float, float], turned: float = 0.0) -> str:
    """Return a status or the result of a comparison with the path: exact or in doubt for polished positions,
    near or off within the error estimate for facets, another place at which the flanks overlap more, or
    nearest points if there is no tangency.

    The pose is rotated by `turned` (rad)."""
    design, scale = case.design, max(1.0, scale_of(case.design))
    ends = path_of_contact(design, case.flank, POINTS).ends
    true = None
    pose = {"pinion_roll": 0.0, "gear_roll": 0.0}
    if ends.status == Status.SOLVED:
        true = path_of_contact(design, case.flank, l1=[ends.l1[0] + case.share * float(np.diff(ends.l1)[0])])
        pose = {"pinion_roll": float(true.pinion_roll[0]), "gear_roll": float(true.gear_roll[0])}
    pose = {"pinion_roll": pose["pinion_roll"] + turned, "gear_roll": pose["gear_roll"] - 0.7 * turned}
    met = mesh_contact(design, case.flank, case.tolerance, **pose, polish=polish)
    if met.status != Status.SOLVED:
        return f"`{met.status.name}`"
    if true is None:
        return "nearest points"
    away = float(np.linalg.norm(met.point - np.array(moved) - true.point[0]))
    if away > met.doubt + EXACT * scale:
        return "another place" if met.separation < -EXACT * scale else WRONG
    if polish:
        return "exact" if met.doubt <= CERTAIN * scale else "in doubt"
    return "near" if away <= NEAR else "off, within estimate"


def of_first_contact(case: Case, path: ContactPath) -> str:
    """Return the verdicts of the certificate, or the first contact if there is no path."""
    if path.l1.size:
        proof = path_certificate(path)
        lost = proof.first.status != FirstStatus.SOLVED
        codes = np.unique(np.where(lost, -proof.first.status, proof.verdict))
        words = [_verdict(int(code)) for code in codes]
        # Tangent flanks do not overlap by a module: another tooth was mistaken for this one.
        overlap = proof.separation < -float(case.design.pinion.tool.normal_module)
        return in_a_cell([WRONG] if overlap.any() else words)
    roll = float(pitch_point_roll(case.design, case.flank))
    pitch = 2.0 * np.pi / float(case.design.pinion.teeth)
    first = first_contact(case.design, case.flank, roll + pitch * np.arange(4) / 4.0)
    edge = (first.limit >= 0).any(axis=-1)
    solved = first.status == FirstStatus.SOLVED
    names = [f"`{FirstStatus(int(code)).name}`" for code in np.unique(first.status[~solved])]
    return in_a_cell(["`EDGE_CONTACT`"] * bool((solved & edge).any()) + names)


def _verdict(code: int) -> str:
    if code == Verdict.FIRST_CONTACT:
        return "holds"
    return f"`{Verdict(code).name}`" if code > 0 else f"`{FirstStatus(-code).name}`"


def cells_of(situation: Situation) -> tuple[str, ...]:
    """Return the outcomes of each of METHODS for the cases of a situation."""
    cells: list[list[str]] = [[] for _ in METHODS]
    for case in situation.cases():
        design, flank = case.design, case.flank
        path = path_of_contact(design, flank, POINTS)
        found = [of_path(design, path), attempted(lambda: _five(design, flank, path))]  # noqa: B023
        with situation.disturbed():
            found += [attempted(lambda: of_meshes(case, polish, situation.moved)) for polish in (False, True)]  # noqa: B023
        found.append(attempted(lambda: of_first_contact(case, path)))  # noqa: B023
        for cell, word in zip(cells, found, strict=True):
            cell.append(word)
    return tuple(in_a_cell(cell) for cell in cells)


def message_in(situation: Situation) -> str:
    """Return the message to the user for the cases of a situation."""
    return in_a_cell(_message(situation, case.design, case.flank) for case in situation.cases())


def _five(design: Design, flank: str, ours: ContactPath) -> str:
    return of_five(design, ours, path_of_contact_five_equations(design, flank, POINTS))


def _message(situation: Situation, design: Design, flank: str) -> str:
    """Return the expected message if it is found, else all messages."""
    texts = list((situation.texts or path_notes)(design, flank))
    if not situation.message:
        return " | ".join(texts) or "nothing"
    found = any(situation.message in text for text in texts)
    return f'"{situation.message}"' if found else f"NO MESSAGE, but: {' | '.join(texts)}"


OF_ASSEMBLY = ("sensitive to errors", "contact is lost within usual tolerances")
"""Remarks on the effect of further errors, which do not depend on the method."""


def on_method(report: ContactReport) -> Iterator[str]:
    """Return the remarks on a path, except those on assembly errors."""
    texts = (remark.text for remark in report.remarks)
    return (text for text in texts if not any(words in text for words in OF_ASSEMBLY))


def path_notes(design: Design, flank: str) -> Iterator[str]:
    """Return the reason for missing contact, or the notes, that `tca --no-certify` prints for the same
    positions."""
    report = contact_report("design", design, flank, 101, "one-equation", certified=False)
    yield from (report.reason,) if report.reason else on_method(report)


def all_notes(design: Design, flank: str) -> Iterator[str]:
    """Return the same with the notes of the certificate."""
    report = contact_report("design", design, flank, POINTS, "one-equation")
    yield from (report.reason,) if report.reason else on_method(report)


def checked(design: Design, flank: str) -> Iterator[str]:
    """Return the remarks of `check` on teeth and layout."""
    yield from (remark.text for remark in remarks_on(design))
