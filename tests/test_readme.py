"""What the README promises: its Python example, its names, its pictures."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

import beveloid_geom

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_python_examples(capsys: pytest.CaptureFixture[str]) -> None:
    examples = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert len(examples) == 2
    scope: dict[str, Any] = {}
    for example in examples:
        exec(compile(example, "README.md", "exec"), scope)
    lines = capsys.readouterr().out.splitlines()
    assert float(lines[0]) == pytest.approx(1.8163, abs=5e-5)
    assert lines[1] == "gear tip pinion tip"
    assert scope["ratios"].shape == (201,)
    assert float(lines[-2].split()[1]) == pytest.approx(0.18, abs=5e-3)
    assert float(lines[-1]) == pytest.approx(0.87, abs=5e-3)
    assert len(scope["certificate"].verdict) == 101
    assert scope["mesh"].hexahedra.shape[1] == 20


def test_every_public_name_is_there() -> None:
    for name in beveloid_geom.__all__:
        assert getattr(beveloid_geom, name).__doc__
    assert set(beveloid_geom.__all__) <= set(dir(beveloid_geom))
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = beveloid_geom.nonsense


def test_pictures_of_the_gallery_exist() -> None:
    shown = set(re.findall(r"\]\((outputs/gallery/[^)]+)\)", README))
    assert shown
    assert shown == {f"outputs/gallery/{p.name}" for p in (ROOT / "outputs/gallery").iterdir()}
