"""How the result of a study is laid out: its dims, by design, and what two scenes share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive.atomic_files import prepare
from harness.archive.case_files import case_folder, write_case
from harness.archive.collection import collect
from harness.archive.conventions import COMPLETED
from harness.archive.study_files import read_study, write_study
from harness.compare.result_table import cone_factor_table
from harness.pictures.pictures import draw
from harness.run.rerun import read_for_rerun, verdict
from harness.study.study import Study, load_study

HEAD = 'title = "t"\nscene = "cone_penetration"\n'
HYPERCUBE = """design = "latin_hypercube"
samples = 20
seed = 3
[vary]
adhesion_factor = { from = 0, to = 1 }
rigidity_index = { from = 5, to = 500, spacing = "logarithmic" }
material = ["tresca", "von_mises"]
"""


def study(folder: Path, text: str) -> Study:
    path = folder / "s.toml"
    path.write_text(text)
    return load_study(str(path))


def collected(tmp_path: Path, text: str) -> xr.Dataset:
    """The dataset of a study whose cases have invented results."""
    made = study(tmp_path, text)
    folder = case_folder(tmp_path, made)
    prepare(folder)
    cases = made.cases
    for place, case in enumerate(cases):
        factor = (), 10.0 + place, {"role": "headline"}
        result = xr.Dataset({"cone_factor": factor, "run_time": 1.0})
        write_case(folder, case, result, COMPLETED)
    return collect(made, folder)


def test_what_is_no_grid_has_a_dimension_of_cases(tmp_path: Path) -> None:
    dataset = collected(tmp_path, HEAD + HYPERCUBE)
    assert dataset["cone_factor"].dims == ("case",)
    assert dataset["rigidity_index"].dims == ("case",)
    assert dataset["density"].dims == ()
    assert np.unique(dataset["case_key"]).size == 20
    write_study(tmp_path / "s.nc", dataset)
    read = read_study(tmp_path / "s.nc")
    assert len(cone_factor_table(read).partition("\n\n")[0].splitlines()) == 23
    assert [path.name for path in draw(read, tmp_path)[0]] == ["s_effects.png"]


def test_derived_parameters_stand_over_the_grid(tmp_path: Path) -> None:
    text = HEAD + '[derived]\ndomain_radius = "6 * sqrt(rigidity_index)"\n'
    text += "[vary]\nrigidity_index = [25, 100]\nadhesion_factor = [0, 1]\n"
    dataset = collected(tmp_path, text)
    assert dataset["domain_radius"].dims == ("rigidity_index", "adhesion_factor")
    assert dataset["domain_radius"].sel(rigidity_index=100).values.tolist() == [60, 60]
    assert cone_factor_table(dataset)
    assert draw(dataset, tmp_path)[0]


OF_TWO_SCENES = {
    "other dims": [
        xr.Dataset({"stress": ("x", [1.0, 2.0])}, {"x": [0.0, 1.0]}),
        xr.Dataset({"stress": (("x", "y"), [[3.0], [4.0]])}, {"x": [0.0, 1.0], "y": [0.0]}),
    ],
    "a dim of its own": [
        xr.Dataset({"displacement": 0.1}),
        xr.Dataset({"load": ("displacement", [1.0, 2.0])}, {"displacement": [0.0, 1.0]}),
    ],
}


@pytest.mark.parametrize("difference", OF_TWO_SCENES)
def test_results_of_one_name_over_other_dims_are_told_apart(
    tmp_path: Path, difference: str
) -> None:
    results = OF_TWO_SCENES[difference]
    text = 'title = "t"\nscene = ["strip_footing", "material_point"]\n'
    made = study(tmp_path, text)
    folder = case_folder(tmp_path, made)
    prepare(folder)
    cases = made.cases
    for case, result in zip(cases, results, strict=True):
        write_case(folder, case, result, COMPLETED)
    write_study(tmp_path / "s.nc", collect(made, folder))
    for case, result in zip(cases, results, strict=True):
        _, before = read_for_rerun(tmp_path / "s.nc", case.key)
        again = result.assign_attrs(status=COMPLETED)
        assert verdict(before, again) == (True, "bit-identical")


def test_a_case_of_several_scenes_is_found_again(tmp_path: Path) -> None:
    text = 'title = "t"\nscene = ["strip_footing", "material_point"]\n'
    dataset = collected(tmp_path, text)
    assert dataset["scene"].values.tolist() == ["strip_footing", "material_point"]
    write_study(tmp_path / "s.nc", dataset)
    for case in study(tmp_path, text).cases:
        found, _ = read_for_rerun(tmp_path / "s.nc", case.key)
        assert found.scene == case.scene
        assert found.parameters == case.parameters
