"""The report in a real browser: it opens without network and leads to every product."""

from __future__ import annotations

import json

import pytest
from projects import Project
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

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
    assert "Result. Of 24 claims" in text(page)
    assert "Transfer ratio on the last task" in text(page)


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
        ("5 Checks", "gain in an experiment after Fernandez and Veloso"),
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
