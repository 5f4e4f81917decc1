"""Built-in designs besides Table 1, whose axes intersect: nothing to object to, and their numbers in closed form.

Their helix angles cancel and their cone angles add up to the shaft angle, so that the pair closes with its
reference cones as pitch cones, whatever the profile shift: that moves tips and thins teeth.
"""

from __future__ import annotations

from math import cos, pi, sin
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import DesignError, builtin_design, certify, mesh_cycle, operating_ratio, path_of_contact
from beveloid_geom.design import file
from beveloid_geom.design.file import BUILTINS, builtin_text, parse_design, read_design
from beveloid_geom.findings.layout import closing_remarks
from beveloid_geom.findings.remarks import NOTE, tip_clearances
from beveloid_geom.pair.closing import closing_of
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import Limit, Status
from tests.oracle.sixty_digits import off_by
from tests.validation.test_intersecting_axes import closed_form

INTERSECTING = ("awd-transfer", "marine-gearbox")
RATIOS = {
    ("awd-transfer", "right"): 0.0,
    ("awd-transfer", "left"): 0.0,
    ("marine-gearbox", "right"): 0.0,
    ("marine-gearbox", "left"): 0.0,
}


def test_every_file_is_listed() -> None:
    folder = Path(file.__file__).parent / "designs"
    assert {path.stem for path in folder.iterdir()} == set(BUILTINS) == {"ni-2017", *INTERSECTING}
