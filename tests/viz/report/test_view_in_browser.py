"""The 3D view of the report in a browser: camera, slider, keys, flanks and paths."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from .browsing import FRAMES, Seen, colours, differing, opened

if TYPE_CHECKING:
    from playwright.sync_api import Browser

COUNT_FRAMES = """() => new Promise(done => {
  const real = window.requestAnimationFrame;
  let count = 0;
  window.requestAnimationFrame = (act) => { count += 1; return real(act); };
  setTimeout(() => { window.requestAnimationFrame = real; done(count); }, 300);
})"""
ALL_ANEW = """Object.defineProperty(window, "beveloidKeptTeeth", {
  get: () => (renderer, { scene, over }) => ({
    render: (camera) => { camera.layers.enable(over); renderer.render(scene, camera); },
    dispose() {},
  }),
  set() {},
});"""
NO_WEBGL = """const real = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
  return kind.startsWith("webgl") ? null : real.call(this, kind, ...rest);
};"""


def test_the_view_shows_something_and_nothing_complains(seen: Seen) -> None:
    assert colours(seen.picture()) > 500
    assert seen.messages == []
    assert len(seen.requests) == 1
    assert seen.page.evaluate("performance.getEntriesByType('resource').length") == 0


def test_nothing_is_drawn_while_nothing_changes(seen: Seen) -> None:
    seen.page.evaluate(FRAMES)
    assert seen.page.evaluate(COUNT_FRAMES) == 0


def test_dragging_turns_the_pair(seen: Seen) -> None:
    seen.press("Pair")
    camera, picture = seen.camera(), seen.picture()
    box = seen.page.locator("#view canvas").bounding_box()
    assert box is not None
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    seen.page.mouse.move(x, y)
    seen.page.mouse.down()
    seen.page.mouse.move(x + 120, y + 40, steps=4)
    seen.page.mouse.up()
    turned = seen.camera()
    assert np.linalg.norm(turned[:3] - camera[:3]) > 50.0
    np.testing.assert_allclose(turned[3:], camera[3:], atol=1e-9)
    assert differing(picture, seen.picture()) > 0.1
    seen.press("Pair")
    np.testing.assert_allclose(seen.camera(), camera, atol=1e-6)


def test_the_wheel_belongs_to_the_page_until_the_view_has_the_focus(seen: Seen) -> None:
    seen.press("Pair")
    seen.page.locator("#view canvas").hover()
    camera = seen.camera()
    for focus, zooms in ((False, False), (True, True)):
        seen.page.evaluate("on => document.querySelector('#view canvas')[on ? 'focus' : 'blur']()", focus)
        place = seen.page.evaluate("scrollY")
        seen.page.mouse.wheel(0, -60)
        seen.page.wait_for_timeout(150)
        assert (seen.page.evaluate("scrollY") == place) == zooms
        assert bool(np.linalg.norm(seen.camera() - camera) > 1.0) == zooms


def test_the_slider_rolls_the_pair(seen: Seen) -> None:
    seen.press("Section at contact")
    picture, roll, text = seen.picture(), seen.roll(), seen.page.locator(".bv-roll").inner_text()
    slider = seen.page.get_by_role("slider", name="Roll of the pinion")
    slider.fill("0.5")
    assert seen.roll() == pytest.approx(roll + 0.5 * 2.0 * math.pi / 29)
    assert seen.page.locator(".bv-roll").inner_text() != text
    assert "0.50 pitches" in seen.page.locator(".bv-roll").inner_text()
    assert differing(picture, seen.picture()) > 0.02
    slider.press("ArrowRight")
    assert seen.roll() == pytest.approx(roll + 0.51 * 2.0 * math.pi / 29)
    seen.page.evaluate("roll => pageView.setRoll(roll)", roll)
    assert differing(picture, seen.picture()) == 0.0
    assert "gear tip touches first" in seen.page.locator(".bv-contact").inner_text()


def test_every_view_and_flank_looks_different(seen: Seen) -> None:
    pictures = []
    for name in ("Pair", "Section at contact", "Left flanks", "Pinion flank", "Gear flank"):
        seen.press(name)
        assert seen.page.get_by_role("button", name=name).get_attribute("aria-pressed") == "true"
        pictures.append(seen.picture())
        assert colours(pictures[-1]) > 200
    assert min(differing(a, b) for i, a in enumerate(pictures) for b in pictures[:i]) > 0.002
    seen.press("Right flanks")


def test_keys_turn_and_gears_can_be_hidden(seen: Seen) -> None:
    seen.press("Pair")
    camera, picture = seen.camera(), seen.picture()
    seen.page.locator("#view canvas").focus()
    seen.page.keyboard.press("ArrowLeft")
    assert np.linalg.norm(seen.camera() - camera) > 10.0
    seen.page.keyboard.press("+")
    away = [float(np.linalg.norm(c[:3] - c[3:])) for c in (camera, seen.camera())]
    assert away[1] < 0.95 * away[0]
    seen.press("Pair")
    for way, least in (("see-through", 0.1), ("hidden", 0.15)):
        seen.page.get_by_label("gear", exact=False).last.select_option(label=way)
        assert differing(picture, seen.picture()) > least


@pytest.mark.parametrize(("flank", "sign"), [("Right flanks", 1.0), ("Left flanks", -1.0)])
def test_the_pinion_drives_while_it_plays(seen: Seen, flank: str, sign: float) -> None:
    seen.press("Pair")
    seen.press(flank)
    before = seen.roll()
    seen.press("Play")
    seen.page.wait_for_timeout(400)
    seen.press("Pause")
    after = seen.roll()
    assert 0.0 < sign * (after - before) < 0.3
    seen.page.wait_for_timeout(100)
    assert seen.roll() == after
    seen.press("Right flanks")


MISSES = """flank => {
  const data = JSON.parse(document.getElementById("view-data").textContent);
  const gears = beveloidGears(data), place = new THREE.Vector3(), misses = [];
  const missed = (line, point) => {
    const corners = line.geometry.attributes.instanceStart, away = [];
    for (let i = 0; i < corners.count; i++) {
      away.push(place.fromBufferAttribute(corners, i).applyMatrix4(line.matrixWorld).distanceTo(point));
    }
    return Math.min(...away);
  };
  for (let n = -10; n <= 10; n++) {
    const { found } = gears.pose(data.roll + 0.2 * n * gears.members[0].pitch, flank, false);
    gears.moveTeeth(0);
    gears.scene.updateMatrixWorld(true);
    found.forEach(({ point }, at) => {
      for (const { meshing } of gears.flanks[flank].drawn) misses.push(missed(meshing[at], point));
    });
  }
  return misses;
}"""


def test_paths_drawn_on_both_gears_run_through_the_dots(seen: Seen, flank: str) -> None:
    """The dots lie on the drawn polylines of both gears, which have 64 points on about 20 mm. All points are
    placed as by the page."""
    misses = seen.page.evaluate(MISSES, flank)
    assert len(misses) >= 2 * 21
    assert max(misses) < 0.25


def test_teeth_from_the_buffer_look_as_if_drawn_anew(browser: Browser, report: Path) -> None:
    """After steps of a hundredth of a pixel and of some pixels, in other views, sizes and colours. The buffer
    mixes the colours of a pixel at an edge before they are encoded for the screen, so that edges differ."""
    pictures: list[list[np.ndarray]] = []
    for script in ("", ALL_ANEW):
        with opened(browser, report, script=script) as seen:
            pictures.append([])
            for name, steps in (("Pair", (1e-6, 0.01, 0.3)), ("Pinion flank", (1e-6, 0.02))):
                seen.press(name)
                for step in steps:
                    seen.page.evaluate("by => pageView.setRoll(pageView.roll() + by)", step)
                    pictures[-1].append(seen.picture())
            seen.page.set_viewport_size({"width": 700, "height": 800})
            seen.page.emulate_media(color_scheme="dark")
            for _ in range(2):
                seen.page.evaluate("pageView.setRoll(pageView.roll())")
                pictures[-1].append(seen.picture())
    kept, anew = pictures
    assert max(differing(a, b) for a, b in zip(kept, anew, strict=True)) < 0.004
    assert differing(kept[0], kept[1]) > 0.01


def test_without_webgl_a_sentence_stands_in_its_place(browser: Browser, report: Path) -> None:
    with opened(browser, report, script=NO_WEBGL) as seen:
        assert "needs WebGL" in seen.page.locator("#view").inner_text()
        assert seen.page.locator("#view canvas").count() == 0
