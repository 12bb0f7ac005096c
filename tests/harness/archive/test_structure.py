"""A result of another program, each thing about it that would be read wrongly."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import xarray as xr

from harness.archive import case_files
from harness.archive import collection as archive
from harness.archive.conventions import COMPLETED
from harness.archive.structure import malformed, outline
from harness.study.study import Study

Change = Callable[[xr.Dataset], xr.Dataset]


def with_attribute(name: str, key: str, value: object) -> Change:
    def change(dataset: xr.Dataset) -> xr.Dataset:
        dataset[name].attrs[key] = value
        return dataset

    return change


FAULTS: list[tuple[str, Change]] = [
    ("there is no case", lambda dataset: dataset.isel(adhesion_factor=slice(0, 0))),
    (
        "adhesion_factor has a value twice",
        lambda dataset: dataset.isel(adhesion_factor=[0, 0, 1]),
    ),
    ("status is no text", lambda dataset: dataset.assign(status=dataset.cone_factor)),
    (
        "cone_factor is no number",
        lambda dataset: dataset.assign(cone_factor=dataset.status.assign_attrs(units="1")),
    ),
    (
        "precision is no number",
        lambda dataset: dataset.assign(
            precision=dataset.precision.assign_attrs(role="error", units="1")
        ),
    ),
    ("the role of cone_factor is unknown", with_attribute("cone_factor", "role", "guess")),
    ("long_name of cone_factor is no text", with_attribute("cone_factor", "long_name", 7)),
    ("limit of cone_factor is no number", with_attribute("cone_factor", "limit", "much")),
    (
        "penetration_resistance has a dim without a coordinate",
        lambda dataset: dataset.drop_vars("penetration"),
    ),
    (
        "penetration_resistance has more than one value a case",
        with_attribute("penetration_resistance", "role", "headline"),
    ),
]


@pytest.fixture
def collected(tmp_path: Path, small: Study) -> xr.Dataset:
    folder = case_files.case_folder(tmp_path, small)
    archive_result = xr.Dataset(
        {
            "cone_factor": ((), 10.0, {"units": "1", "role": "headline"}),
            "penetration_resistance": ("penetration", [1.0, 2.0], {"units": "Pa"}),
        },
        {"penetration": ("penetration", [0.1, 0.2], {"units": "1"})},
    )
    folder.mkdir(parents=True)
    for case in small.cases:
        case_files.write_case(folder, case, archive_result, COMPLETED)
    return archive.collect(small, folder)


def test_what_is_collected_is_well_formed(collected: xr.Dataset) -> None:
    assert malformed(outline(collected)) is None


@pytest.mark.parametrize(("fault", "change"), FAULTS, ids=[fault for fault, _ in FAULTS])
def test_a_fault_is_told_in_words(collected: xr.Dataset, fault: str, change: Change) -> None:
    assert malformed(outline(change(collected))) == fault
