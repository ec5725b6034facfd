"""First page and ledger in a real browser, on a desk and on a phone."""

from __future__ import annotations

from pathlib import Path

import pytest
from made_up_run import MadeUpRun
from matplotlib.figure import Figure
from selenium.webdriver.common.by import By
from test_front_page import ARGUMENTS

from ptl import claims
from ptl.claims.degrees import degrees_of
from ptl.report import ledger
from ptl.report.front_page import compose_page

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pages")
    (folder / "figures").mkdir()
    for name, width in (("front", 13.3), ("front_narrow", 5.3), ("figure12", 13.3)):
        Figure(figsize=(width, 6)).savefig(folder / f"figures/{name}.png", dpi=50)
    figures, tables = {"figure12": ("Figure 12: steps", "Mean.", False)}, {"table1": "Table 1. Jump start"}
    titles = {"env1": "An environment with a long name"}
    page = compose_page(**ARGUMENTS | {"titles": titles}, figures=figures, tables=tables, caption="All tasks.")
    (folder / "index.html").write_text(page)
    evidence = MadeUpRun().evidence()
    judged = claims.judge(evidence)
    entries = [*map(ledger.Entry, judged, judged, degrees_of(claims.CLAIMS, evidence))]
    (folder / "claims.html").write_text(ledger.to_html(entries, "30 seeds."))
    return folder


@pytest.fixture
def opened(browser, folder):
    def open_page(name: str, width: int):
        metrics = {"width": width, "height": 844, "deviceScaleFactor": 1, "mobile": width < 500}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        browser.get((folder / name).as_uri())
        return browser

    yield open_page
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.mark.parametrize("width", [1400, 390])
@pytest.mark.parametrize("name", ["index.html", "claims.html"])
def test_a_page_is_no_wider_than_the_screen(opened, name: str, width: int) -> None:
    page = opened(name, width)
    assert page.execute_script("return document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize(("width", "picture"), [(1400, "front.png"), (390, "front_narrow.png")])
def test_the_picture_fits_the_screen(opened, width: int, picture: str) -> None:
    image = opened("index.html", width).find_element(By.CSS_SELECTOR, ".front img")
    assert image.get_property("currentSrc").endswith(f"/{picture}")
    assert image.rect["width"] <= width


def test_a_figure_on_a_phone_is_large_and_scrolls(opened) -> None:
    page = opened("index.html", 390)
    link = page.find_element(By.CSS_SELECTOR, "#figure12 a.scroll")
    inner, outer = page.execute_script("return [arguments[0].scrollWidth, arguments[0].clientWidth]", link)
    assert inner > 1.5 * outer
    hint = "return getComputedStyle(document.querySelector('#figure12 figcaption'), '::before').content"
    assert "↔" in page.execute_script(hint)


@pytest.mark.parametrize(("width", "cut"), [(1400, False), (280, True)])
def test_a_shadow_shows_that_a_table_scrolls(opened, width: int, cut: bool) -> None:
    page = opened("index.html", width)
    box = page.find_element(By.CSS_SELECTOR, "div.scroll")
    inner, outer = page.execute_script("return [arguments[0].scrollWidth, arguments[0].clientWidth]", box)
    assert (inner > outer) == cut
    attachments = box.value_of_css_property("background-attachment")
    assert attachments.count("local") == attachments.count("scroll") == 2


def test_each_claim_has_the_colour_of_its_class(opened, folder: Path) -> None:
    page = opened("claims.html", 1400)
    colour = "return getComputedStyle(document.querySelector(arguments[0]), '::before').backgroundColor"
    for name in {row.get_attribute("class") for row in page.find_elements(By.CSS_SELECTOR, "tbody tr")}:
        row, count = (page.execute_script(colour, place) for place in (f"tr.{name} th.claim", f".counts li.{name}"))
        assert row == count != "rgba(0, 0, 0, 0)"
