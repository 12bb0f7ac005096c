"""Results of other programs with the right digest: each is refused in a line, or read as it is.

A mutant is a result in which one thing is missing, renamed, of another type or of another size.
Whatever reads it tells that in one line that names the file, or does what it does with a whole
result.
"""

import random
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
import xarray as xr

from harness.archive import netcdf_files
from harness.archive.atomic_files import ArchiveError
from harness.archive.case_files import case_file, case_folder, read_case, read_outcome
from harness.archive.conventions import COMPLETED, DAMAGED
from harness.archive.study_files import read_study
from harness.cli.commands import run as run_commands
from harness.pictures import pictures
from harness.pictures.drawing.plot_parts import MAKER
from harness.report import report as page
from harness.run.collect_and_clean import collect_and_write
from harness.run.worker import compute
from harness.study.study import Study
from tests.harness.conftest import Depth, Refusal, answered, keep, study_in

pytestmark = pytest.mark.slow

STUDY = """
title = "mutants"
scene = "cone_penetration"
fixed = { penetration = 1, steady_tolerance = 0, particles_per_cell = 4 }
vary = { adhesion_factor = [0, 1], cells_per_radius = [1, 1.5] }
[compare]
references = ["lu_2004"]
tolerance = { cone_factor_variation = 10 }
"""
WRONG: tuple[Any, ...] = (7, -1.5, float("nan"), "", "\x1b[2J", "a\nb", np.arange(3), ["a", "b"])
"""What an attribute may be instead."""


Variable = tuple[tuple[str, ...], Any, dict[str, Any]]
"""Dims, values and attributes."""


@dataclass(frozen=True)
class Content:
    """What a file of netCDF holds, whether it goes together or not."""

    attributes: dict[str, Any]
    variables: dict[str, Variable]

    @classmethod
    def read(cls, path: Path) -> "Content":
        with netCDF4.Dataset(path) as file:
            file.set_auto_maskandscale(False)
            variables = {
                name: (it.dimensions, np.asarray(it[...]), dict(it.__dict__))
                for name, it in file.variables.items()
            }
            return cls(dict(file.__dict__), variables)

    def write(self, path: Path) -> None:
        """Write it, and the right digest."""
        beside = path.with_suffix(".plain")
        with netCDF4.Dataset(beside, "w") as file:
            file.setncatts(self.attributes)
            for name, (dims, values, said) in self.variables.items():
                for dim, size in zip(dims, values.shape, strict=True):
                    if dim not in file.dimensions:
                        file.createDimension(dim, size)
                kind = str if values.dtype.kind in "OU" else values.dtype
                made = file.createVariable(name, kind, dims, fill_value=said.get("_FillValue"))
                made.setncatts({key: it for key, it in said.items() if key != "_FillValue"})
                made.set_auto_maskandscale(False)
                made[...] = values if values.ndim else values.item()
        content = beside.read_bytes()
        beside.unlink()
        path.write_bytes(content + netcdf_files._digest(content))


Mutation = Callable[[random.Random, Content], tuple[str, Content]]


def without(source: random.Random, content: Content) -> tuple[str, Content]:
    name = source.choice(list(content.variables))
    others = {key: it for key, it in content.variables.items() if key != name}
    return f"no {name}", replace(content, variables=others)


def of_variable(change: Callable[[random.Random, str, Variable], tuple[str, Variable]]) -> Mutation:
    """A mutation that changes one variable: its dims, its values or its attributes."""

    def mutated(source: random.Random, content: Content) -> tuple[str, Content]:
        name = source.choice(list(content.variables))
        what, other = change(source, name, content.variables[name])
        return f"{name} {what}", replace(content, variables=content.variables | {name: other})

    return mutated


@of_variable
def retyped(source: random.Random, name: str, old: Variable) -> tuple[str, Variable]:
    dims, values, said = old
    if values.dtype.kind in "OU":
        other = np.arange(values.size, dtype=float).reshape(values.shape)
    else:
        text = values.astype(str).astype(object)
        with np.errstate(invalid="ignore"):  # what is not a number is no integer
            whole = values.astype("i1")
        other = source.choice([text, values.astype("S1"), whole, values * np.nan])
    said = {key: it for key, it in said.items() if key != "_FillValue"}
    return f"as {other.dtype}", (dims, other, said)


@of_variable
def resized(source: random.Random, name: str, old: Variable) -> tuple[str, Variable]:
    dims, values, said = old
    sizes: list[tuple[tuple[str, ...], Any]] = [
        ((*dims, "another"), np.stack([values, values], axis=-1)),
        (("nothing",), np.zeros(0)),
    ]
    if dims:
        sizes += [
            (dims[1:], values[0]),
            (dims[::-1], values.T),
            (dims, np.broadcast_to(values.ravel()[0], values.shape)),
        ]
    if dims and name not in dims:  # netCDF itself writes no dim whose variable has another one
        sizes.append((("shorter", *dims[1:]), values[:1]))
    other_dims, other = source.choice(sizes)
    return f"over {other_dims}", (other_dims, other, said)


@of_variable
def another_attribute(source: random.Random, name: str, old: Variable) -> tuple[str, Variable]:
    dims, values, said = old
    extra = ["_FillValue", "scale_factor", "coordinates", "role", "limit", "exact_of", "dtype"]
    key = source.choice([*said, *extra])
    other = {it: value for it, value in said.items() if it != "_FillValue"}
    other[key] = source.choice(WRONG)
    if key == "_FillValue":
        other[key] = values.ravel()[0] if values.size and values.dtype.kind in "biuf" else None
    return f"with {key} {other[key]!r}", (dims, values, other)


def another_word(source: random.Random, content: Content) -> tuple[str, Content]:
    """An attribute of the file that is missing or of another type."""
    key = source.choice([it for it in content.attributes if it != "digest"])
    others = {it: value for it, value in content.attributes.items() if it != key}
    if source.random() < 0.3:
        return f"no {key}", replace(content, attributes=others)
    other = source.choice(WRONG)
    return f"{key}: {other!r}", replace(content, attributes=others | {key: other})


MUTATIONS = (without, retyped, resized, another_attribute, another_word)


def mutants(path: Path, count: int) -> Iterator[str]:
    """Write mutants of the file in its place, one after the other, and tell what each is."""
    source, whole = random.Random(23), Content.read(path)
    for number in range(count):
        what, mutant = MUTATIONS[number % len(MUTATIONS)](source, whole)
        mutant.write(path)
        yield what


@pytest.fixture(scope="module")
def computed(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """A study of four cases, collected, beside its file; one case was computed for all of them."""
    folder = tmp_path_factory.mktemp("mutants")
    study = study_in(folder, STUDY, name="many")
    result = compute(study.cases[0]).dataset
    names = ["cone_factor", "run_time"]
    with xr.set_options(keep_attrs=True):
        results = [result.assign(result[names] * (1 + 0.1 * number)) for number in range(4)]
    keep(study, folder, *results)
    collect_and_write(study, folder)
    return study


@pytest.fixture
def out(computed: Study, tmp_path: Path) -> Path:
    """Results of one's own to be changed."""
    place = tmp_path / "results"
    shutil.copytree(computed.source.parent, place)
    return place


def fault_of(read: Callable[[], object]) -> str:
    """Why a file cannot be read; "" where it can."""
    try:
        read()
    except ArchiveError as error:
        return str(error)
    return ""


def test_a_mutant_of_a_case_file_is_damaged_or_can_be_collected_and_read(
    computed: Study, out: Path, depth: Depth
) -> None:
    count = depth(32, 1000)
    folder, case = case_folder(out, computed), computed.cases[1]
    path = case_file(folder, case)
    damaged = 0
    for what in mutants(path, count):
        outcome, fault = read_outcome(folder, case), fault_of(lambda: read_case(folder, case))
        assert (outcome.status == DAMAGED) == bool(fault), (what, outcome, fault)
        if fault:
            assert outcome.message == fault, what
            assert fault.startswith(f"{path}: "), what
            damaged += 1
            if damaged > 2:
                continue  # what is damaged is collected in the same way
        code, _ = answered(["collect", str(computed.source), "--out", str(out)])
        assert code == (0 if outcome.status == COMPLETED else 1), what
        assert read_study(out / "many.nc").attrs["study"] == "many", what
    assert damaged > count // 4


def commands(path: Path, whole: Path, key: str) -> list[list[str]]:
    return [
        ["compare", str(path)],
        ["compare", str(path), str(whole)],
        ["recommend", "cone_penetration", "--error", "100%", "--results", str(path.parent)],
        ["plot", str(path)],
        ["report", str(path), "-o", str(path.with_suffix(".html"))],
        ["rerun", str(path), key],
    ]


def test_a_mutant_of_a_collected_file_is_refused_in_a_line_or_read(
    computed: Study, out: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, depth: Depth
) -> None:
    count, case, path = depth(32, 1000), computed.cases[1], out / "many.nc"
    whole = shutil.copy(path, tmp_path / "whole.nc")
    again = read_case(case_folder(out, computed), case)
    monkeypatch.setattr(run_commands, "rerun", lambda *_, **__: again)  # takes seconds each
    for module in (pictures, page):  # and so does each picture
        monkeypatch.setattr(module, "image", lambda *_, **__: MAKER.encode())
    refused = 0
    for number, what in enumerate(mutants(path, count)):
        every = commands(path, whole, case.key)
        # What cannot be read is refused in the same place by all of them.
        is_refused = fault_of(lambda: read_study(path))
        for command in [every[number % len(every)]] if is_refused else every:
            code, told = answered(command)
            if code == 2:
                (line,) = told.splitlines()
                # A result without what a command is for is none that it is meant for.
                known = (str(path), "no result", "no stored result", "nothing to compare")
                assert any(it in line for it in known), (what, line)
                assert len(line) < 400 + len(str(out)), what
                refused += 1
    assert refused > count // 4


def test_a_result_with_an_unknown_reference_is_told_by_its_file(
    computed: Study, out: Path, refusal: Refusal
) -> None:
    path, known = out / "many.nc", "reference_lu_2004"
    variables = dict((whole := Content.read(path)).variables)
    replace(whole, variables=variables | {f"{known}_": variables.pop(known)}).write(path)
    line = refusal(["compare", str(path)])
    assert str(path) in line
    assert "unknown reference 'lu_2004_'" in line


@pytest.mark.parametrize("name", ["adhesion_factor", "cone_factor", "penetration_resistance"])
def test_a_role_of_many_numbers_is_told(computed: Study, out: Path, name: str) -> None:
    path = case_file(case_folder(out, computed), computed.cases[0])
    dims, values, said = (whole := Content.read(path)).variables[name]
    changed = whole.variables | {name: (dims, values, said | {"role": np.arange(3)})}
    replace(whole, variables=changed).write(path)
    told = read_outcome(path.parent, computed.cases[0]).message
    assert told.endswith(f"the role of {name} is unknown")


@pytest.mark.parametrize("key", ["status", "scene"])
def test_an_attribute_of_many_numbers_is_told(computed: Study, out: Path, key: str) -> None:
    path = case_file(case_folder(out, computed), computed.cases[0])
    whole = Content.read(path)
    replace(whole, attributes=whole.attributes | {key: np.arange(3)}).write(path)
    told = read_outcome(path.parent, computed.cases[0]).message
    assert told.endswith(f"{key} is neither a text nor a number")
