"""Positions of Table 1 with the paper's modification, at which methods are compared, solved to 60 digits.

Run `python -m tests.validation.stored_positions` and store the output in `positions_of_table1.json`.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from beveloid_geom import builtin_design, path_of_contact
from beveloid_geom.validation.comparison import POSITION_COUNT, solved_positions

PARABOLA = (0.001, -0.001)


def cases() -> list[dict[str, Any]]:
    """Return pinion and gear roll (rad), l1 and the point in S_f (mm) of each position of both flanks."""
    found = []
    for flank in ("right", "left"):
        path = path_of_contact(builtin_design().with_parabola(*PARABOLA), flank, 2 * POSITION_COUNT + 1)
        columns = (path.l1, path.u1, path.l2, path.u2, path.pinion_roll, path.gear_roll)
        numbers = solved_positions(path.design, flank, np.stack(columns, axis=-1)[1::2])
        found.append({"flank": flank, "parabola": PARABOLA, "positions": numbers.tolist()})
    return found


if __name__ == "__main__":
    print("[" + ",\n".join(json.dumps(case) for case in cases()) + "]")
