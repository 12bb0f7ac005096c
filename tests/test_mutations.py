"""The deliberate errors of `mutations.toml` fit the tree as it is; `mutations.py` tries them."""

import subprocess
import sys

import pytest

from tests.mutations import MUTATIONS, ROOT


def test_each_error_is_of_a_text_that_stands_once_in_its_file() -> None:
    assert [fault for it in MUTATIONS if (fault := it.fault())] == []


def test_each_error_has_a_meaning_of_its_own() -> None:
    assert len({it.meaning for it in MUTATIONS}) == len(MUTATIONS)


@pytest.mark.slow
def test_each_error_names_a_test_that_is_collected() -> None:
    """Its parameters too, which pytest numbers; a name may be that of all of them, or of a file."""
    named = {it.test for it in MUTATIONS}
    collect = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-m", "", *sorted(named)]
    output = subprocess.run(collect, check=False, cwd=ROOT, capture_output=True, text=True).stdout
    collected = set(output.splitlines())
    of_functions = {test.partition("[")[0] for test in collected}
    of_files = {test.partition("::")[0] for test in collected}
    assert named <= collected | of_functions | of_files
