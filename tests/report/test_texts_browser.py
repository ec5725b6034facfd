"""A whole run whose titles and labels are hostile, in a real browser: nothing runs, nothing is loaded."""

from __future__ import annotations

import json
import time

import pytest
from hostile_texts import TITLES
from projects import ROOMS, TINY, Project
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

pytestmark = pytest.mark.browser

DANGEROUS = [text for text in TITLES if not set(text) & set("<{}")][:8]
"""Titles of the environments of the run: entities, code and pictures in other languages."""

PAGES = ("report.html", "index.html", "explorer.html", "tables/table1.html")


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Project:
    project = Project(tmp_path_factory.mktemp("texts"), methods=["no_transfer", "ptl"])
    entries = {f"rooms{number}": {"map": "rooms.txt", "title": text} for number, text in enumerate(DANGEROUS)}
    project.configure(
        {**project.config, "environments": entries, "seeds": 1, "growth": {**TINY["growth"], "environment": "rooms0"}}
    )
    assert (project.folder / "rooms.txt").read_text() == ROOMS
    project.make()
    project.make("--report", "reports/tiny/report.html")
    return project


@pytest.mark.parametrize("name", PAGES)
def test_nothing_runs_and_nothing_is_loaded(browser, run, name):
    browser.get("about:blank")
    browser.get_log("performance")
    browser.get_log("browser")
    browser.get((run.folder / "reports/tiny" / name).as_uri())
    time.sleep(1)
    if name == "report.html":  # go to where the labels are
        for section in ("Figures", "Tables"):
            found = WebDriverWait(browser, 20).until(
                lambda driver, section=section: driver.find_elements(By.XPATH, f"//a[contains(., '{section}')]")
            )
            browser.execute_script("arguments[0].click()", found[0])
            wanted = f"map of {DANGEROUS[1]}" if section == "Figures" else DANGEROUS[1]
            WebDriverWait(browser, 20).until(
                lambda driver, wanted=wanted: wanted in driver.find_element(By.TAG_NAME, "body").text
            )
            browser.refresh()
    else:
        WebDriverWait(browser, 20).until(
            lambda driver: DANGEROUS[0] in driver.page_source or DANGEROUS[0] in body(driver)
        )
    assert browser.execute_script("return window.hacked") is None
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    requests = [
        message["params"]["request"]["url"] for message in messages if message["method"] == "Network.requestWillBeSent"
    ]
    assert requests and not [url for url in requests if not url.startswith(("file:", "data:", "blob:", "about:"))]
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []


def body(driver) -> str:
    return driver.find_element(By.TAG_NAME, "body").text
