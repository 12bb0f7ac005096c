"""Damage on disk: flipped bits, cut files, and what is no file at all."""

import os
from collections.abc import Callable
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from harness.archive import netcdf_files
from harness.archive.atomic_files import ArchiveError
from harness.archive.case_files import case_file, case_folder, is_complete, read_case, read_outcome
from harness.archive.conventions import COMPLETED, DAMAGED
from harness.archive.netcdf_files import read_netcdf, write_netcdf
from harness.cli.main import main
from harness.run.collect_and_clean import collect_and_write
from harness.run.worker import run_case
from harness.study.study import Study
from tests.harness.conftest import Command, Depth, Refusal, keep, prepared, study_in

STUDIES = {
    "cone_penetration": (
        "penetration = 1\nsteady_tolerance = 0\ncells_per_radius = 1\nparticles_per_cell = 4"
    ),
    "sliding_block": "cells_per_length = 10\ntravel = 0.01",
    "material_point": "step_count = 16",
}
COMMANDS = ("compare", "plot", "report", "recommend")


@pytest.fixture(scope="module", params=list(STUDIES))
def computed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Study:
    """A study of one case, computed and collected; the results stand beside its file."""
    folder = tmp_path_factory.mktemp(request.param)
    text = f'title = "one"\nscene = "{request.param}"\n[fixed]\n{STUDIES[request.param]}\n'
    study = study_in(folder, text, name="one")
    assert run_case(study.cases[0], prepared(study, folder)).status == COMPLETED
    collect_and_write(study, folder)
    return study


def flipped(content: bytes, bit: int) -> bytes:
    changed = bytearray(content)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


def flips(content: bytes, count: int) -> list[int]:
    return np.random.default_rng(23).integers(8 * len(content), size=count).tolist()


def read(path: Path) -> xr.Dataset | str:
    """What a file holds, or why it cannot be read; any other exception fails the test."""
    try:
        return read_netcdf(path)
    except ArchiveError as error:
        return str(error)


def is_same(one: xr.Dataset, other: xr.Dataset) -> bool:
    dtypes = ({name: it.dtype for name, it in each.variables.items()} for each in (one, other))
    return one.identical(other) and next(dtypes) == next(dtypes)


@pytest.mark.parametrize("collected", [False, True])
def test_a_flipped_bit_of_a_result_is_noticed_or_changes_nothing(
    collected: bool, computed: Study, tmp_path: Path, depth: Depth
) -> None:
    out, (case,) = computed.source.parent, computed.cases
    whole = out / "one.nc" if collected else case_file(case_folder(out, computed), case)
    path = case_file(tmp_path, case)
    path.write_bytes(content := whole.read_bytes())
    before, stand, noticed = read_netcdf(path), read_outcome(tmp_path, case), 0
    for bit in flips(content, depth(50, 5000) // len(STUDIES)):
        path.write_bytes(flipped(content, bit))
        outcome, after = read_outcome(tmp_path, case), read(path)
        if isinstance(after, str):
            assert after.startswith(f"{path}: ")
            assert outcome.status == DAMAGED
            noticed += 1
        else:
            assert is_same(after, before)
            assert outcome == stand
    assert noticed


def test_a_flipped_bit_at_the_edges_of_netcdf_and_digest_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    write_netcdf(xr.Dataset({"a": 1.0}, attrs={"format_version": 1}), path)
    content = path.read_bytes()
    for byte in (0, len(content) // 2, len(content) - 73, len(content) - 72, len(content) - 1):
        path.write_bytes(flipped(content, 8 * byte))
        with pytest.raises(ArchiveError, match="was damaged or changed after it was written"):
            read_netcdf(path)


@pytest.fixture
def result(small: Study, tmp_path: Path) -> Path:
    """The collected file of a study of which all cases are complete."""
    keep(small, tmp_path)
    collect_and_write(small, tmp_path)
    return tmp_path / "small.nc"


def arguments(command: str, result: Path) -> list[str]:
    if command == "recommend":
        return [command, "cone_penetration", "--error", "1%", "--results", str(result.parent)]
    more = ["-o", str(result.with_suffix(".html"))] if command == "report" else []
    return [command, str(result), *more]


def truncated(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-100])


def cut_by_the_digest(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-72])


def changed(path: Path) -> None:
    with xr.open_dataset(path) as dataset:
        other = dataset.load()
    other["cone_factor"] = other["cone_factor"] + 1
    other.to_netcdf(path)


def fifo(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


def folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def device(path: Path) -> None:
    path.unlink()
    path.symlink_to("/dev/zero")


def bomb(path: Path) -> None:
    """A tera of numbers in a file of some kilobytes, of another program."""
    path.unlink()
    with netCDF4.Dataset(path, "w") as file:
        file.format_version = np.int64(1)
        file.study = "small"
        file.scene = "cone_penetration"
        file.createDimension("case", 10**12)
        file.createVariable("status", "f8", ("case",), zlib=True, chunksizes=(1000,))


@pytest.mark.parametrize("kind", ["list", "enumeration", "a dim twice"])
def test_what_xarray_would_read_by_half_is_told_in_a_line(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "other.nc"
    with netCDF4.Dataset(path, "w") as file:
        file.format_version = np.int64(1)
        file.createDimension("case", 2)
        of: object = "f8"
        if kind == "list":
            of = file.createVLType("f8", "lists")
        elif kind == "enumeration":
            of = file.createEnumType("i1", "names", {"one": 1})
        dims = ("case", "case") if kind == "a dim twice" else ("case",)
        file.createVariable("cone_factor", of, dims)
    told = "a dim twice" if kind == "a dim twice" else "not an array of numbers or texts"
    with pytest.raises(ArchiveError, match=rf"cannot be read: .*cone_factor .*{told}"):
        read_netcdf(path, as_result=False)


def test_coordinates_that_are_not_there_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / "other.nc"
    with netCDF4.Dataset(path, "w") as file:
        file.format_version = np.int64(1)
        file.coordinates = "depth"
        file.createVariable("cone_factor", "f8", ())[...] = 10.5
    assert float(read_netcdf(path, as_result=False).cone_factor) == 10.5


DAMAGES = (truncated, cut_by_the_digest, changed, fifo, folder, device, bomb)


@pytest.mark.parametrize("command", ["report", "plot"])
def test_a_study_in_place_of_its_results_is_told_what_to_give(
    command: str, small: Study, refusal: Refusal
) -> None:
    line = refusal(arguments(command, small.source))
    assert line.endswith("; give the .nc file that `harness run` wrote")


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_collected_file_of_no_use_is_one_line_and_collected_again(
    damage: Callable[[Path], None], result: Path, small: Study, refusal: Refusal
) -> None:
    """For each command that reads it; of numbers that do not fit into memory none is read."""
    damage(result)
    for command in COMMANDS:
        line = refusal(arguments(command, result))
        assert line.startswith(f"harness: {result}: cannot be read: ")
        assert ("more than it can hold" in line) == (damage is bomb)
        assert len(line) < 200 + len(str(result))
    again = ["collect", str(small.source), "--out", str(result.parent)]
    if damage in (folder, bomb):  # of another program: it stays as it is
        assert "and will not be overwritten" in refusal(again)
    else:
        assert main(again) == 0
        assert read_netcdf(result).attrs["study"] == "small"


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_case_file_of_no_use_is_damaged(
    damage: Callable[[Path], None], result: Path, small: Study, command: Command
) -> None:
    place, case = case_folder(result.parent, small), small.cases[1]
    path, of_study = case_file(place, case), (small.source, "--out", result.parent)
    damage(path)
    lines = command("status", *of_study, code=1).out.splitlines()
    assert f"{path}: cannot be read: " in lines[2]
    assert lines[-1].startswith("3 cases: 2 completed, 1 damaged")
    if damage not in (folder, fifo):
        return  # that it is run again is the same for all, and takes seconds
    told = command("run", *of_study, code=2 if damage is folder else 0).err
    assert is_complete(place, case) == (damage is fifo)
    if damage is folder:
        assert told.splitlines()[-1].endswith("is a folder among result files; move it away")
    else:
        assert "the case is run again" in told
        assert "3 cases, 2 done already" in told


def of_another_program(path: Path) -> None:
    """Write a result as another program does: its numbers, and no word of a digest."""
    path.write_bytes(bytes(netcdf_files._image(read_netcdf(path))))


def test_a_result_of_another_program_is_read_as_any(result: Path, small: Study) -> None:
    place, case = case_folder(result.parent, small), small.cases[0]
    before, stand = read_case(place, case), read_outcome(place, case)
    assert before is not None
    of_another_program(case_file(place, case))
    after = read_case(place, case)
    assert after is not None
    assert is_same(after, before)
    assert read_outcome(place, case) == stand


def test_damage_in_the_mark_and_anywhere_else_is_seen_before_the_library_sees_the_file(
    result: Path, monkeypatch: pytest.MonkeyPatch, depth: Depth
) -> None:
    def fail(*_: object, **__: object) -> None:
        pytest.fail("the library has seen the file")

    monkeypatch.setattr(netCDF4, "Dataset", fail)
    content = result.read_bytes()
    start = 8 * (len(content) - 72)
    for number, other in enumerate(flips(content, depth(64, 5000))):
        result.write_bytes(flipped(flipped(content, start + number % 64), other))
        assert "its digest is missing" in str(read(result))
    for cut in (1, 8, 64, 71, 72, 73, 100, len(content) // 2, len(content) - 8, len(content)):
        result.write_bytes(content[:-cut])
        assert "cannot be read: it " in str(read(result))
    statement = netcdf_files._STATEMENT.encode()
    without = content.replace(statement, b"-" * len(statement))
    result.write_bytes(without[:-73])
    assert "its end is missing" in str(read(result))


def test_a_digest_is_of_the_file_and_not_of_the_result(result: Path) -> None:
    with xr.open_dataset(result) as dataset:  # as any program reads it
        assert dataset.attrs["digest"].startswith("SHA-256")
    assert "digest" not in read_netcdf(result).attrs
