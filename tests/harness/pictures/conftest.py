"""Results that are made up, one for each kind of design."""

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.text import Text

from harness.archive.collection import collect
from harness.compare.compared import with_references
from harness.pictures.pictures import rendered
from harness.references.registry import reference_of
from mpm_warp.results import Drawn
from tests.harness.conftest import as_collected, keep, study_in

REFERENCES = ("lu_2004", "teh_houlsby_1991", "yu_2000")
STRENGTH = 20e3
SOIL = {
    "rigidity_index": 100.0,
    "adhesion_factor": 0.5,
    "friction_coefficient": 0.0,
    "material": "tresca",
    "undrained_shear_strength": STRENGTH,
}
OVER_STRENGTH = {
    "long_name": "net cone resistance",
    "units": "Pa",
    "description": "as simulated",
    **Drawn(picture="resistance", divided_by="undrained_shear_strength").attributes,
}
Columns = Mapping[str, Sequence[object]]


def result(
    varied: Columns,
    factor: Sequence[float] | None = None,
    design: str = "full",
    uncertainty: float | None = None,
) -> xr.Dataset:
    """A study's result with invented cone factors.

    Args:
        varied: the values of each parameter: those of a grid, or of each case in other designs.
        factor: cone factors of the cases, not a number where one failed; default: rising.
        design: of the study.
        uncertainty: half width of each cone factor's interval.
    """
    full = design == "full"
    dims = tuple(varied) if full else ("case",)
    shape = [len(values) for values in varied.values()][: None if full else 1]
    soil = {name: value for name, value in SOIL.items() if name not in varied}
    made = xr.Dataset(
        {name: ((), value, _labels(name, value)) for name, value in soil.items()},
        coords={
            name: (name if full else "case", list(values), _labels(name, values[0]))
            for name, values in varied.items()
        },
    )
    count = int(np.prod(shape, dtype=int))
    if not full:
        made = made.assign_coords(case=np.arange(count))
    values = np.reshape(11 + 0.1 * np.arange(count) if factor is None else factor, shape)
    labels = {"units": "1", "long_name": "cone factor", "role": "headline"}
    made["cone_factor"] = dims, values.astype(float), labels
    if uncertainty is not None:
        made["cone_factor_uncertainty"] = dims, np.full(shape, uncertainty), {"role": "uncertainty"}
    status = np.where(np.isfinite(made["cone_factor"]), "completed", "diverged")
    said = {"study": "demo", "title": "A demonstration", "design": design}
    made = as_collected(made, dims, status, **said)
    made["particle_updates"] = dims, np.reshape(1e6 * (1.0 + np.arange(count)), shape)
    depth = xr.DataArray(np.arange(1.0, 19.0), dims="penetration")
    resistance = made["cone_factor"] * STRENGTH * depth / 18
    made["penetration_resistance"] = resistance.assign_attrs(OVER_STRENGTH)
    made = made.assign_coords(penetration=depth)
    made["penetration"].attrs = {"units": "1", "long_name": "penetration over cone radius"}
    return with_references(made, [reference_of(it) for it in REFERENCES])


def _labels(name: str, value: object) -> dict[str, str]:
    labels = {"role": "parameter", "long_name": name.replace("_", " ")}
    units = {"undrained_shear_strength": "Pa", "mean_effective_stress": "Pa"}
    return labels if isinstance(value, str) else labels | {"units": units.get(name, "1")}


def one_at_a_time() -> xr.Dataset:
    """A start, and five cases that differ from it in one parameter; one failed."""
    columns = {
        "rigidity_index": [100.0, 25.0, 500.0, 100.0, 100.0, 100.0],
        "adhesion_factor": [0.5, 0.5, 0.5, 1.0, 0.5, 0.5],
        "material": ["tresca", "tresca", "tresca", "tresca", "von_mises", "tresca"],
        "speed_ratio": [0.03, 0.03, 0.03, 0.03, 0.03, 0.5],
    }
    return result(columns, [11.0, 8.0, 14.0, 11.8, 10.2, np.nan], "one_at_a_time")


def a_few_cases() -> xr.Dataset:
    """Four cases that differ in four parameters, one of which a single case has; one failed."""
    columns = {
        "material": ["tresca", "von_mises", "tresca", "tresca"],
        "adhesion_factor": [0.5, 0.5, 1.0, 0.5],
        "apex_angle": [60.0, 60.0, 120.0, 90.0],
        "mean_effective_stress": [np.nan, np.nan, np.nan, 60e3],
    }
    return result(columns, [11.0, 10.2, 13.1, np.nan], "list", uncertainty=0.2)


def many_differences() -> xr.Dataset:
    """Three cases, the last of which differs from the others in many parameters."""
    names = ("remoulded_strength_ratio", "reference_strain_rate", "strength_compression")
    columns = {name: [1.0, 1.0, 0.5] for name in (*names, "strength_simple_shear", "rate_factor")}
    return result(columns, [11.0, 10.2, 13.1], "list", uncertainty=0.2)


def random_cases(count: int = 40) -> xr.Dataset:
    """Cone factors that are a sum of what three random parameters do, a tenth of them failed."""
    random = np.random.default_rng(1)
    index, adhesion = np.exp(random.uniform(3, 6, count)), random.uniform(0, 1, count)
    material = random.choice(["tresca", "von_mises"], count)
    factor = 2.0 * np.log(index) + 1.5 * adhesion - 0.8 * (material == "von_mises")
    factor[::10] = np.nan
    columns = {
        "rigidity_index": index.tolist(),
        "adhesion_factor": adhesion.tolist(),
        "material": material.tolist(),
    }
    return result(columns, factor.tolist(), "latin_hypercube")


MADE: Mapping[str, Callable[[], xr.Dataset]] = {
    "one parameter": lambda: result(
        {"rigidity_index": [25.0, 50.0, 100.0, 200.0, 300.0, 500.0]}, uncertainty=0.3
    ),
    "two parameters": lambda: result(
        {"rigidity_index": [25.0, 50.0, 100.0, 500.0], "adhesion_factor": [0.0, 0.25, 0.5, 1.0]},
        uncertainty=0.1,
    ),
    "a text and many values": lambda: result(
        {"material": ["tresca", "von_mises"], "apex_angle": [30.0, 45.0, 59.0, 60.0, 61.0, 150.0]}
    ),
    "one at a time": one_at_a_time,
    "at random": random_cases,
    "a few cases": a_few_cases,
    "many differences": many_differences,
    "a mesh": lambda: result(
        {"cells_per_radius": [2.0, 4.0, 8.0, 16.0], "adhesion_factor": [0.0, 1.0]},
        [10.0 + 1.0 / n + a for n in (2.0, 4.0, 8.0, 16.0) for a in (0.0, 1.5)],
        uncertainty=0.05,
    ),
}
"""One result of each kind, by what it varies."""


def figures(dataset: xr.Dataset) -> dict[str, Figure]:
    """The pictures of a result, none of which fails."""
    made, failed = rendered(dataset, lambda figure: figure)
    assert failed == {}
    return made


IN_A_ROW = (
    'design = "list"\n[[case]]\nadhesion_factor = 0\n[[case]]\nadhesion_factor = 1\n',
    'design = "one_at_a_time"\n[vary]\nadhesion_factor = [1]\n',
    'design = "latin_hypercube"\nsamples = 2\nseed = 1\n[vary.adhesion_factor]\nfrom = 0\nto = 1\n',
)
"""Designs of two cases along the dim `case`."""


def collected(folder: Path, scene: str, design: str, *results: xr.Dataset) -> xr.Dataset:
    """What a study collects whose cases have these results."""
    study = study_in(folder, f'title = "t"\nscene = "{scene}"\n{design}')
    of_cases = [one.drop_attrs(deep=False) for one in results]  # what tells of a study among them
    return collect(study, keep(study, folder, *of_cases))


def texts(written: Iterable[Text]) -> list[str]:
    """What is written there."""
    return [text.get_text() for text in written]


def legend(figure: Figure) -> list[str]:
    """What the legends of a figure say."""
    return texts(text for shown in figure.legends for text in shown.get_texts())


def caption_of(figure: Figure) -> str:
    """What stands below a figure, in one line."""
    return " ".join(str(figure.get_supxlabel()).split())


@functools.cache
def drawn(kind: str) -> tuple[xr.Dataset, dict[str, Figure]]:
    """A made-up result with its pictures, which take long to draw: each is drawn once."""
    dataset = MADE[kind]()
    return dataset, figures(dataset)


@pytest.fixture(params=MADE)
def made_up(request: pytest.FixtureRequest) -> tuple[xr.Dataset, dict[str, Figure]]:
    """Each of the made-up results with its pictures."""
    return drawn(request.param)
