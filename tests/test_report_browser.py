"""Reports in a real Chromium: the 3D view draws, obeys its controls, and nothing is fetched or complained about."""

from __future__ import annotations

import io
import time
from collections.abc import Iterator

import numpy as np
import pytest
from browser import PATIENCE_S, Page, find_browser, open_browser
from PIL import Image
from report_workspaces import make_workspace

from neurframe_cli.pipeline.report_step import write_report
from neurframe_cli.report.vtkjs import viewer_script

pytestmark = [
    pytest.mark.skipif(
        find_browser() is None, reason="no chromium and chromedriver (Debian: chromium-driver)"
    ),
    pytest.mark.skipif(viewer_script() is None, reason="trame-vtk (extra `report`) is not installed"),
    pytest.mark.slow,
]

READY = "document.getElementById('view3d').dataset.ready"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    with open_browser(tmp_path_factory.mktemp("browser")) as page:
        yield page


@pytest.fixture(scope="module")
def report(browser: Page, tmp_path_factory: pytest.TempPathFactory) -> Page:
    """The report of a cube with an invalid hex mesh, in the browser, its 3D view drawn."""
    hostile = "</script><script>window.hacked=1</script><img src=x onerror='window.hacked=1'>"
    folder = make_workspace(tmp_path_factory.mktemp("report") / "<b>", valid=False, warning=hostile)
    browser.open(write_report(folder).as_uri())
    browser.wait_for(READY)
    return browser


def pixels(page: Page) -> np.ndarray:
    """(h,w,3) of the 3D view as it is on the screen."""
    page.run("document.getElementById('view3d').scrollIntoView()")
    return np.asarray(Image.open(io.BytesIO(page.picture_of("#view3d"))).convert("RGB")).astype(int)


def changed(page: Page, before: np.ndarray, share: float) -> np.ndarray:
    """The pixels once that share of them is no longer what it was: a picture is on the screen some frames late."""
    deadline = time.monotonic() + PATIENCE_S
    while True:
        now = pixels(page)
        if now.shape == before.shape and (np.abs(now - before).max(axis=2) > 24).mean() > share:
            return now
        assert time.monotonic() < deadline, "the view has not changed"
        time.sleep(0.3)


def test_the_mesh_is_drawn(report: Page) -> None:
    drawn = changed(report, np.full_like(pixels(report), 255), 0.05)
    # the cube is seen from a corner: background all round, three sides in different light
    assert (drawn[[5, 5, -5, -5], [5, -5, 5, -5]] == drawn[5, 5]).all()
    shades = [tuple(color) for color in drawn.reshape(-1, 3)[::7]]
    common = [color for color in set(shades) if shades.count(color) > 0.02 * len(shades)]
    assert len(common) >= 4


def test_nothing_is_fetched_and_nothing_complained_about(report: Page) -> None:
    assert report.errors() == []
    asked = [address for address in report.requests() if not address.startswith("chrome")]
    assert asked, "the page itself is a request"
    assert all(address.startswith("file:///") and address.endswith("/report.html") for address in asked)
    assert report.run("return window.hacked === undefined")


def test_the_cut_and_the_places_change_the_view(report: Page) -> None:
    whole = pixels(report)
    choose = "const s = document.querySelector('#view-controls select'); s.selectedIndex = arguments[0];"
    report.run(choose + "s.dispatchEvent(new Event('change'));", 1)
    cut = changed(report, whole, 0.02)
    # half of the cube is gone
    background = whole[5, 5]
    assert (cut != background).any(axis=2).sum() < (whole != background).any(axis=2).sum()
    report.run(choose + "s.dispatchEvent(new Event('change'));", 0)
    changed(report, cut, 0.02)
    report.run("document.querySelector('button.goto').click()")
    near = changed(report, whole, 0.2)
    report.run(
        "[...document.querySelectorAll('#view-controls button')].find((b) => b.textContent === 'reset').click()"
    )
    changed(report, near, 0.2)
    assert report.errors() == []


def test_layers_are_switched(report: Page) -> None:
    before = pixels(report)
    report.run("document.querySelectorAll('#view-controls input[data-layer]')[0].click()")
    changed(report, before, 0.05)
    assert report.errors() == []
