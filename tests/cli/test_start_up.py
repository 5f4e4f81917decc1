"""What commands import: no more than they need, as it is most of the time that they take to start."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.running import imported_by

PICTURES = "matplotlib", "pyvista", "vtkmodules"
SURFACE = "mesh --tolerance 0.05"
SLOW: dict[str, tuple[str, ...]] = {
    "tca --help": ("numpy", "scipy", "pydantic", "beveloid_viz", *PICTURES),
    "design": ("scipy", "beveloid_viz", *PICTURES),
    "tca --points 3": ("scipy", "beveloid_viz", *PICTURES),
    "check ni-2017": ("beveloid_viz", *PICTURES),
    "mesh --help": ("numpy", "scipy", "trimesh", "meshio", "tqdm", "pyvista", "OCP"),
    f"{SURFACE} --part pinion-tooth --out a.vtp": ("trimesh", "meshio", "OCP", "pyvista", "vtkmodules"),
    f"{SURFACE} --part gear-tooth --out a.stl": ("OCP", "pyvista", "vtkmodules", "beveloid_viz"),
    "mesh --part gear-flank --out a.vtu": ("trimesh", "OCP", "pyvista", "vtkmodules", "beveloid_viz"),
}


@pytest.mark.parametrize("command", SLOW)
def test_commands_import_no_more_than_they_need(tmp_path: Path, command: str) -> None:
    imported = imported_by(*command.split(), folder=tmp_path)
    own = "beveloid_geom.cli.commands.mesh" if command.startswith("mesh") else "beveloid_geom.cli.main"
    assert own in imported
    assert not imported & set(SLOW[command])
