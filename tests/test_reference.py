"""The reference: each public name has an example that runs, and pdoc makes the pages."""

import doctest
import importlib
import re
import sys
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path

import numpy as np
import pytest

import mpm_warp
from tests.conftest import finished

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "tests/README.md").read_text(encoding="utf-8")
(COMMAND,) = re.findall(r"^\.venv/bin/python -m (pdoc .*?[^\\])$", PAGE, re.MULTILINE | re.DOTALL)
WORDS = COMMAND.replace("\\\n", " ").split()
MODULES = [word for word in WORDS if word.startswith("harness.")]


def test_each_public_name_but_errors_has_an_example_that_runs() -> None:
    names = {name: getattr(mpm_warp, name) for name in dir(mpm_warp)}
    finder = doctest.DocTestFinder(recurse=False, exclude_empty=False)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    for name, value in names.items():
        given = {**names, "np": np, "dataclass": dataclass}
        (found,) = finder.find(value, name, globs=given)
        is_error = isinstance(value, type) and issubclass(value, Exception)
        assert bool(found.examples) != is_error, name
        runner.run(found)
    assert not runner.summarize().failed


def test_each_argument_of_a_public_class_is_declared_or_documented() -> None:
    for owner in filter(is_dataclass, (getattr(mpm_warp, name) for name in dir(mpm_warp))):
        told = "\n".join(base.__doc__ or "" for base in owner.__mro__)
        for field in fields(owner):
            is_declared = field.metadata.get("meaning") or field.metadata.get("group")
            in_words = re.search(rf"^ +(\w+, )*{field.name}(, \w+)*: ", told, re.MULTILINE)
            assert is_declared or in_words, (owner.__name__, field.name)


@pytest.mark.parametrize("module", MODULES)
def test_examples_of_the_harness_run(module: str) -> None:
    assert not doctest.testmod(importlib.import_module(module)).failed


@pytest.mark.slow
def test_pdoc_makes_the_pages_without_a_warning(tmp_path: Path) -> None:
    words = [str(tmp_path) if word == "docs" else word for word in WORDS]
    end = finished([sys.executable, "-m", *words], cwd=ROOT)
    assert (end.returncode, end.stderr) == (0, "")
    page = (tmp_path / "mpm_warp.html").read_text(encoding="utf-8")
    assert [name for name in dir(mpm_warp) if f'id="{name}"' not in page] == []
    assert "undrained shear strength su [Pa]; &gt; 0" in page
    for module in MODULES:
        assert tmp_path.joinpath(*module.split(".")).with_suffix(".html").exists()
