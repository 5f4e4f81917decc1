"""Every example runs, draws one picture, and prints its number."""

from __future__ import annotations

import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

EXAMPLES = Path(__file__).parents[2] / "viz/examples"
NUMBERS = {
    "plot_01_paper_pair": ("contact_ratio", 1.651001052),
    "plot_02_own_pair": ("offset", 119.0262507),
    "plot_03_misalignment": ("shift_per_mm", 32.6932415),
    "plot_04_modification": ("contact_ratio", 1.5),
    "plot_05_transmission_error": ("peak_to_peak", 8.778692191e-06),
    "plot_06_solid": ("volume", 2950857.9099877),
    "plot_07_tooth_for_calculix": ("semi_axis", 13.5476579),
    "plot_08_many_mountings": ("median_ratio", 1.816201063),
    "plot_09_own_figure": ("px_per_mm", 11.38194733),
    "plot_10_notebook": ("greatest", 1.9153064),
    "plot_11_explore": ("at_the_end", 1.215455753),
}
MOST_LINES = 40


def test_every_example_has_its_number() -> None:
    files = {path.name for path in EXAMPLES.iterdir() if path.is_file()}
    assert files == {"GALLERY_HEADER.rst", *(f"{name}.py" for name in NUMBERS)}


@pytest.mark.parametrize("name", NUMBERS)
def test_example(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if name == "plot_11_explore":
        pytest.importorskip("aiohttp", reason="needs the extra `explore`")
    shown: list[int] = []
    monkeypatch.setattr(plt, "show", lambda: shown.append(len(plt.get_fignums())))
    monkeypatch.chdir(tmp_path)
    file = EXAMPLES / f"{name}.py"
    assert len(file.read_text(encoding="utf-8").splitlines()) <= MOST_LINES
    try:
        found = runpy.run_path(str(file))
    finally:
        plt.close("all")
    assert shown == [1]
    variable, value = NUMBERS[name]
    assert found[variable] == pytest.approx(value, rel=1e-7)
