"""What the README promises: its Python example, its names, its pictures; and the links of all pages."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

import beveloid_geom

ROOT = Path(__file__).parents[1]
PAGES = [
    ROOT / "README.md",
    *(p for folder in ("beveloid_geom", "viz", "tests") for p in (ROOT / folder).rglob("README.md")),
]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_python_example(capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    scope: dict[str, Any] = {}
    exec(compile(example, "README.md", "exec"), scope)
    lines = capsys.readouterr().out.splitlines()
    assert float(lines[0]) == pytest.approx(1.8163, abs=5e-5)
    assert lines[1:3] == ["gear tip pinion tip", "False"]
    assert float(lines[3]) == pytest.approx(0.18, abs=5e-3)
    assert scope["ratios"].shape == (201,)


def test_the_front_page_is_short() -> None:
    assert len(README.splitlines()) <= 150


def test_links_between_pages_lead_somewhere() -> None:
    for page in PAGES:
        for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            assert (page.parent / link).exists(), f"{page}: {link}"


def test_every_public_name_is_there() -> None:
    assert all(getattr(beveloid_geom, name).__doc__ for name in beveloid_geom.__all__)
    assert set(beveloid_geom.__all__) <= set(dir(beveloid_geom))
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = beveloid_geom.nonsense


def test_pictures_of_the_gallery_are_shown() -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    shown = set(re.findall(r"gallery/([^)\s]+)\)", text))
    assert shown == {path.name for path in (ROOT / "outputs/gallery").iterdir()}
