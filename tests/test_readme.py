"""What the README promises: its Python example, its names, its pictures."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import beveloid_geom

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_python_example(capsys: pytest.CaptureFixture[str]) -> None:
    example = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    assert example
    scope: dict[str, object] = {}
    exec(compile(example[1], "README.md", "exec"), scope)
    lines = capsys.readouterr().out.splitlines()
    assert float(lines[0]) == pytest.approx(1.8163, abs=5e-5)
    assert lines[1] == "gear tip pinion tip"
    ratios = scope["ratios"]
    assert getattr(ratios, "shape", None) == (201,)


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
