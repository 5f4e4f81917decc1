"""The figure `sliding`: its numbers are the library's."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import Errors, builtin_design, path_of_contact, sliding_of

from .pages import drawn, texts, words


@pytest.mark.parametrize(("offset", "lost"), [(0.0, 0), (1.6, 1), (50.0, 2)])
def test_figure_has_the_numbers_or_the_reason(offset: float, lost: int) -> None:
    design = builtin_design().with_errors(Errors(offset=offset))
    page, rows = drawn("sliding", design)
    assert words(page).count("no contact: the path of contact does not meet") == 2 * lost
    assert texts(page).count("pitch point") == 2 - lost
    known = [row for row in rows if not row["reason"]]
    assert len(rows) - len(known) == 2 * lost
    if offset == 0.0:
        found = sliding_of(path_of_contact(design, "right", 201))
        shown = [row["pinion_specific"] for row in known if row["flank"] == "right"][:201]
        np.testing.assert_array_equal(shown, found.specific[:, 0])
