"""The page in a browser, as a reader uses it; where there is no browser, these are skipped.

`.ci/run` installs one and sets BROWSER_DEMANDED: then a missing one is an error.
"""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement

BROWSER, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
DEMANDED = "BROWSER_DEMANDED" in os.environ

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not DEMANDED and (BROWSER is None or DRIVER is None), reason="no chromium with its driver"
    ),
]


@pytest.fixture(scope="module")
def browser() -> Iterator[webdriver.Chrome]:
    """One browser for all tests, without a screen and without a network."""
    assert BROWSER is not None, "chromium is demanded"
    assert DRIVER is not None, "chromium-driver is demanded"
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for argument in (
        "--headless=new",
        "--no-sandbox",  # as root there is none
        "--disable-dev-shm-usage",
        "--disable-gpu",
        "--host-resolver-rules=MAP * ~NOTFOUND",
    ):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    driver.set_page_load_timeout(120)
    yield driver
    driver.quit()


@pytest.fixture
def opened(browser: webdriver.Chrome, page_file: Path) -> webdriver.Chrome:
    """The page, loaded anew in a window of a desktop."""
    browser.set_window_size(1280, 900)
    browser.get(page_file.as_uri())
    return browser


def first(browser: webdriver.Chrome, selector: str) -> WebElement:
    return browser.find_element(By.CSS_SELECTOR, selector)


def press(browser: webdriver.Chrome, element: WebElement) -> None:
    browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", element)
    element.click()


def column(browser: webdriver.Chrome, name: str) -> int:
    """Place of a column of the first study's cases."""
    headings = browser.find_elements(By.CSS_SELECTOR, "#study-1 .cases thead tr:first-child th")
    return next(place for place, it in enumerate(headings) if it.text.startswith(name))


def shown(browser: webdriver.Chrome, name: str) -> list[str]:
    """What a column of the first study shows."""
    place = column(browser, name)
    rows = browser.find_elements(By.CSS_SELECTOR, "#study-1 .cases tbody tr")
    return [row.find_elements(By.TAG_NAME, "td")[place].text for row in rows if row.is_displayed()]


def test_it_loads_without_an_error_and_titles_stay_text(opened: webdriver.Chrome) -> None:
    assert opened.get_log("browser") == []
    assert opened.title.startswith("Nc < 12 & <script>")
    assert (
        first(opened, "#study-1 h2").text == "Nc < 12 & <script>document.title = 'changed'</script>"
    )
    assert opened.execute_script("return performance.getEntriesByType('resource').length") == 0


def test_cases_are_sorted_by_number_both_ways(opened: webdriver.Chrome) -> None:
    heading = opened.find_elements(By.CSS_SELECTOR, "#study-1 .cases thead th")[
        column(opened, "run time")
    ]
    press(opened, heading.find_element(By.TAG_NAME, "button"))
    assert shown(opened, "run time") == ["1", "9", "10", "-"]
    assert heading.get_attribute("aria-sort") == "ascending"
    press(opened, heading.find_element(By.TAG_NAME, "button"))
    assert shown(opened, "run time") == ["10", "9", "1", "-"]


def test_cases_are_filtered_by_words_and_bounds(opened: webdriver.Chrome) -> None:
    inputs = opened.find_elements(By.CSS_SELECTOR, "#study-1 .filters input")
    index, outcome = (inputs[column(opened, name) - 1] for name in ("rigidity", "outcome"))
    index.send_keys(">= 100")
    assert shown(opened, "rigidity") == ["100", "200", "1000"]
    outcome.send_keys("DIV")
    assert shown(opened, "rigidity") == ["1000"]
    assert "1 of 4 cases" in first(opened, "#study-1 output").text
    for field in (outcome, index):
        field.send_keys(Keys.CONTROL, "a", Keys.DELETE)
    assert len(shown(opened, "rigidity")) == 4


def test_a_picture_is_enlarged_and_closed_again(opened: webdriver.Chrome) -> None:
    small = first(opened, ".picture img")
    width = small.size["width"]
    press(opened, first(opened, ".picture"))
    assert first(opened, "dialog img").size["width"] > 1.2 * width
    opened.switch_to.active_element.send_keys(Keys.ESCAPE)
    assert not first(opened, "dialog").is_displayed()


def test_all_parameters_of_a_case_are_shown(opened: webdriver.Chrome) -> None:
    press(opened, first(opened, "#study-1 .more"))
    rows = [
        [cell.text for cell in row.find_elements(By.TAG_NAME, "td")]
        for row in opened.find_elements(By.CSS_SELECTOR, "dialog tr")
    ]
    assert ["rigidity_index", "50", ""] in rows
    assert ["cells_per_radius", "2", ""] in rows


def test_provenance_is_folded_away(opened: webdriver.Chrome) -> None:
    folded = first(opened, "#study-1 .provenance")
    assert not folded.find_element(By.TAG_NAME, "table").is_displayed()
    press(opened, folded.find_element(By.TAG_NAME, "summary"))
    assert "<b>unknown</b>" in folded.text


@pytest.mark.parametrize("width", [360, 768, 1280])
def test_no_screen_is_too_narrow(opened: webdriver.Chrome, width: int) -> None:
    metrics = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    opened.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    overflow = opened.execute_script(
        "return document.documentElement.scrollWidth - document.documentElement.clientWidth"
    )
    opened.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert overflow <= 0


def brightness(browser: webdriver.Chrome, scheme: str) -> tuple[int, int]:
    """Of ink and paper, in sums of red, green and blue."""
    feature = {"name": "prefers-color-scheme", "value": scheme}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
    styles = (
        first(browser, "body").value_of_css_property(it) for it in ("color", "background-color")
    )
    ink, paper = (
        sum(int(it) for it in style.partition("(")[2].rstrip(")").split(",")[:3])
        for style in styles
    )
    return ink, paper


def test_light_and_dark_follow_the_reader(opened: webdriver.Chrome) -> None:
    light, dark = (brightness(opened, scheme) for scheme in ("light", "dark"))
    middle = 3 * 255 / 2
    assert light[0] < middle < light[1]
    assert dark[1] < middle < dark[0]


def test_it_prints_without_what_is_for_the_screen(opened: webdriver.Chrome) -> None:
    opened.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    assert not first(opened, ".filters").is_displayed()
    assert not first(opened, "nav").is_displayed()
    assert opened.print_page().startswith("JVBER")  # a PDF, in base 64
    opened.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
