"""The report in a real browser: it opens without network and leads to every product."""

from __future__ import annotations

import json

import pytest
from projects import Project
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

from ptl.claims import CLAIMS

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def address(tiny: Project, tmp_path_factory) -> str:
    path = tmp_path_factory.mktemp("report") / "report.html"
    tiny.make("--report", path)
    return path.as_uri()


@pytest.fixture
def page(browser, address):
    browser.set_window_size(1400, 1000)
    browser.get("about:blank")
    browser.get_log("performance")
    browser.get_log("browser")
    browser.get(address)
    wait = WebDriverWait(browser, 20)
    wait.until(lambda driver: "Question." in driver.find_element(By.TAG_NAME, "body").text)
    return browser


def text(page) -> str:
    return page.find_element(By.TAG_NAME, "body").text


def click(page, words: str) -> None:
    found = WebDriverWait(page, 20).until(
        lambda driver: [one for one in driver.find_elements(By.XPATH, f"//*[text()='{words}']") if one.is_displayed()]
    )
    found[0].click()


def test_front_page_asks_and_answers(page):
    assert "Partial transfer learning: a reproduction" in text(page)
    assert f"Result. Of {len(CLAIMS)} claims" in text(page)
    assert "Steps saved, in % of those without transfer" in text(page)


@pytest.mark.parametrize(
    ("category", "item"),
    [
        ("1 Verdicts", "Claims: verdict and numbers for every claim"),
        ("1 Verdicts", "Differences: the article's statements beside our numbers"),
        ("2 Figures", "growth of the skill library"),
        ("2 Figures", "Discovery"),
        ("2 Figures", "map of "),
        ("3 Tables", "Table 2. Total performance and transfer ratio"),
        ("2 Figures", "steps per episode on the last task"),
    ],
)
def test_categories_lead_to_the_products(page, category, item):
    click(page, category)
    WebDriverWait(page, 20).until(lambda driver: item in text(driver))


def test_no_request_leaves_the_page_and_the_console_is_clean(page):
    click(page, "3 Tables")
    messages = [json.loads(entry["message"])["message"] for entry in page.get_log("performance")]
    requests = [
        message["params"]["request"]["url"] for message in messages if message["method"] == "Network.requestWillBeSent"
    ]
    assert requests and not [url for url in requests if not url.startswith(("file:", "data:", "blob:"))]
    assert [entry for entry in page.get_log("browser") if entry["level"] == "SEVERE"] == []


@pytest.fixture
def sized(page):
    """The report in a window of another size."""

    def resize(width: int, height: int = 844):
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
        page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        return page

    yield resize
    page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def open_first(page, category: str) -> None:
    click(page, category)
    views = "#app nav a[href='#'] svg"
    WebDriverWait(page, 20).until(lambda driver: len(driver.find_elements(By.CSS_SELECTOR, views)) > 4)
    page.execute_script(
        "[...document.querySelectorAll('#app nav a')].find(a => a.getBoundingClientRect().width == 24).click()"
    )
    WebDriverWait(page, 20).until(lambda driver: driver.find_elements(By.CSS_SELECTOR, "#app iframe, #app img"))


BOXES = """
const box = (element) => element.getBoundingClientRect();
const nav = box(document.querySelector('#app > div > nav'));
const content = box(document.querySelector('#app > div > nav + div'));
return {width: document.documentElement.scrollWidth, nav: [nav.left, nav.right, nav.bottom],
        content: [content.left, content.right, content.top, content.height]};
"""


def test_on_a_phone_menu_and_table_stay_on_the_screen(sized):
    page = sized(390)
    open_first(page, "3 Tables")
    boxes = page.execute_script(BOXES)
    assert boxes["width"] == 390 == boxes["nav"][1] == boxes["content"][1]
    assert boxes["nav"][0] == 0 == boxes["content"][0]
    assert 100 < boxes["nav"][2] <= boxes["content"][2] + 1 < 0.6 * 844, "the table is below the menu, and seen"
    click(page, "Results")
    click(page, "2 Figures")


def test_on_a_laptop_a_table_has_three_quarters_of_the_width(sized):
    page = sized(1280, 800)
    open_first(page, "3 Tables")
    left, right, _, _ = page.execute_script(BOXES)["content"]
    assert right == 1280 and left <= 330
    page.switch_to.frame(page.find_element(By.CSS_SELECTOR, "#app iframe"))
    widths = page.execute_script("const s = document.querySelector('.scroll'); return [s.scrollWidth, s.clientWidth]")
    page.switch_to.default_content()
    assert widths[0] <= widths[1], "every column is seen"
