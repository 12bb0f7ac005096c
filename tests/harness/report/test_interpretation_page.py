"""The page of interpreted cone tests: what may be quoted, what it stands on, what it is not."""

import html
import re
from pathlib import Path

import pytest

from harness.cli.main import main
from tests.harness.conftest import Refusal
from tests.harness.interpret import conftest
from tests.harness.interpret.conftest import DEPTH, SITE, STRENGTH, changed, measured_rows

LAYER = f'{conftest.LAYER}rigidity_strength = "average"\n'  # all is said
ASSUMED = """
[[layer]]
title = "assumed <clay>"
from = 10
to = 11
rigidity_index = { low = 50, high = 300 }
adhesion_factor = "sleeve"
[[layer]]
from = 12
to = 20
rigidity_index = 100
"""


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What is written of two tests."""
    folder = tmp_path_factory.mktemp("page")
    (folder / "test.csv").write_text(measured_rows(DEPTH, 11.5 * STRENGTH, 0.4 * STRENGTH))
    (folder / "a.v1.toml").write_text(SITE + LAYER)
    (folder / "b.toml").write_text(SITE.replace("A site", "B site") + LAYER + ASSUMED)
    emptied = ("\n5,", "\n5,,,\n5.05,"), ("\n7,", "\n7,,,\n7.02,,,\n7.05,")
    changed(folder, *emptied, file="test.csv")
    both = [str(folder / f"{it}.toml") for it in ("a.v1", "b")]
    assert main(["interpret", *both, "--out", str(folder / "out")]) == 0
    return folder / "out"


@pytest.fixture(scope="module")
def page(written: Path) -> str:
    return (written / "soundings_interpretation.html").read_text()


def words(page: str) -> str:
    """What a reader sees, in one line."""
    return " ".join(html.unescape(re.sub(r"<(style|[^>]*)>", " ", page)).split())


def test_what_it_is_not_stands_in_plain_words_and_nothing_is_fetched_or_runs(page: str) -> None:
    assert "not a characteristic or design value" in words(page)
    assert "not the strength of soil that drains" in words(page)
    assert not re.search(r"https?://|<script|<clay>", page)


def test_the_sentence_the_picture_and_all_inputs_of_each_test_are_there(page: str) -> None:
    assert page.count('src="data:image/png;base64,') == 3
    assert 'href="#test-2">B site<' in page
    _, first, second = map(words, re.split(r'id="test-\d"', page))
    assert "2 to 10 m: su (isotropic, at 0.36 %/h)" in first
    assert "rigidity_index 120 120 (120 to 120)" in first
    assert re.search(r"cause 2 to 10 m numerical (99|100) %", first)
    assert re.search(r"2 to 10 m 2 to 10 8\.\d+ \([\d.]+ to [\d.]+\) 1\.\d+ \(1", first)
    assert "2 to 10 m value missing 3 84 5, 7 to 7.02" in first
    assert "area_ratio 0.8 net area ratio of the cone" in first
    assert "(assumed)" not in first
    # Known exactly in one layer, and no strength in the last: neither has a share.
    assert re.search(r" K0 - \d+ % - ", second)
    assert re.search(r" numerical \d+ % \d+ % - ", second)
    assert "assumed <clay> K0 low 0.5, high 0.8 (assumed)" in second
    assert "assumed <clay> adhesion_factor sleeve" in second
    assert "assumed <clay> rigidity_strength average (assumed)" in second


def test_each_test_and_both_together_have_files(written: Path) -> None:
    assert sorted(it.name for it in written.iterdir()) == [
        f"{name}_interpretation{form}"
        for name, forms in (
            ("a.v1", (".csv", ".nc", ".png", "_lines.csv")),
            ("b", (".csv", ".nc", ".png", "_lines.csv")),
            ("soundings", (".html", ".png")),
        )
        for form in forms
    ]


def test_two_site_files_of_one_name_are_refused(tmp_path: Path, refusal: Refusal) -> None:
    for place in ("a", "b"):
        (tmp_path / place).mkdir()
        (tmp_path / place / "site.toml").write_text(SITE + LAYER)
    both = [str(tmp_path / it / "site.toml") for it in ("a", "b")]
    line = refusal(["interpret", *both, "--out", str(tmp_path / "out")])
    assert "site.toml: another result has this name" in line
