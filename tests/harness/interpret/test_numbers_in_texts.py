"""What Python would take for a number, and no file of others means, is refused by every reader."""

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harness.benchmark.cases import read_results
from harness.cli.options import number, positive_count, share
from harness.errors import HarnessError
from harness.interpret.laboratory import read_tests
from harness.interpret.site import load_site
from harness.study.study import study_of_scene
from mpm_warp.errors import ParameterError
from mpm_warp.fields.plain_numbers import numbers_by_column, plain_number
from mpm_warp.scenes.sounding.table import columns_of as columns_of_profile
from tests.harness.interpret.conftest import changed, write_site
from tests.harness.interpret.written_tests import WRITERS, columns_of, rows_of, site_of

FULL_WIDTH = "\uff11\uff10"
NOT_PLAIN = ("1_0", FULL_WIDTH, "1e5_0", "1_0.5", "0x10", "infinity", "-inf", "1e400", "9" * 5000)
"""Python's float takes all but the hexadecimal one."""


def written(folder: Path, text: str) -> Path:
    (folder / "numbers.csv").write_text(text, encoding="utf-8")
    return folder / "numbers.csv"


def cell_of(kind: str, cell: str) -> Callable[[Path, str], object]:
    """A reader of a measured test in which a cell has that text."""

    def read(folder: Path, text: str) -> object:
        write_site(folder)
        test = WRITERS[kind](rows_of(folder))
        assert test.count(cell) == 1
        site = site_of(folder, kind, "")
        changed_test = test.replace(cell, cell.replace("1.5", text))
        (folder / f"test.{kind}").write_text(changed_test, encoding="utf-8")
        return columns_of(site)

    return read


def laboratory_rate(folder: Path, text: str) -> object:
    write_site(folder)
    return load_site(changed(folder, ("laboratory_rate = 1e-6", f'laboratory_rate = "{text} %/h"')))


READERS: dict[str, Callable[[Path, str], object]] = {
    "csv": cell_of("csv", "\n1.5,"),
    "gef": cell_of("gef", "; 1.5; "),
    "xml": cell_of("xml", ",1.5,"),
    "ags": cell_of("ags", '"1.5"'),
    "cpt": cell_of("cpt", "D=1.5,"),
    "percent an hour": laboratory_rate,
    "laboratory": lambda folder, text: read_tests(
        written(folder, f"depth [m],strength [kPa],test\n5,{text},DSS\n")
    ),
    "profile": lambda _, text: columns_of_profile(f"depth [m], strength [kPa]\n{text}, 20\n"),
    "benchmark": lambda folder, text: read_results(
        written(folder, f"case,value,uncertainty,seconds\ncone_100_smooth,{text},0.1,7\n")
    ),
    "--tolerance": lambda _, text: number("any")(text),
    "--error": lambda _, text: share(f"{text}%"),
    "--memory-limit": lambda _, text: number("any", {"GB": 1e9})(f"{text}GB"),
    "--workers": lambda _, text: positive_count(text),
    "--set": lambda _, text: study_of_scene("cone_penetration", [f"density={text}"]),
    "--set of several": lambda _, text: study_of_scene(
        "cone_penetration", [f"density=[1, {text}]"]
    ),
}
REFUSED = HarnessError, ParameterError, argparse.ArgumentTypeError


@pytest.mark.parametrize("reader", READERS)
def test_no_reader_takes_it(folder: Path, reader: str) -> None:
    read = READERS[reader]
    read(folder, "10" if reader == "--workers" else "1.5")
    for text in NOT_PLAIN:
        with pytest.raises(REFUSED) as refused:
            read(folder, text)
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize("text", [*NOT_PLAIN, "nan", "1,5", "1 0", "-", "e5", ".", "n/a"])
def test_no_table_of_this_project_has_it(text: str) -> None:
    assert plain_number(text) is None
    with pytest.raises(ValueError, match=r"^'.*' is no number as 1\.5 or 1\.5e-3$"):
        numbers_by_column(f"a,b\n1,2\n3,'{text}'\n".replace("'", '"'))


def test_a_table_has_plain_numbers_by_column() -> None:
    found = numbers_by_column("# a comment\na,b\n10,-.5\n+1.,1.5e-3\n2E+5, \n")
    assert found["a"].tolist() == [10.0, 1.0, 2e5]
    assert found["b"].tolist()[:2] == [-0.5, 1.5e-3]
    assert np.isnan(found["b"][2])
