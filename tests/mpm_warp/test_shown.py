"""How scenes and runs are shown at the prompt and in Jupyter."""

from typing import Any

import pytest
import tqdm.auto

from mpm_warp import CatalogueScene, ConePenetration, GravityColumn, Scene, Simulation, Sounding


@pytest.mark.parametrize(
    ("scene", "text"),
    [
        (ConePenetration(), "ConePenetration()"),
        (ConePenetration(rigidity_index=100), "ConePenetration()"),
        (
            ConePenetration(rigidity_index=150, material="von_mises", cells_per_radius=3),
            "ConePenetration(rigidity_index=150.0, material='von_mises', cells_per_radius=3.0)",
        ),
        (GravityColumn(cell_count=3), "GravityColumn(cell_count=3)"),
        (Sounding(layer_thickness=None), "Sounding()"),
    ],
)
def test_a_scene_is_shown_by_what_differs_from_its_defaults_as_it_can_be_typed(
    scene: CatalogueScene, text: str
) -> None:
    assert repr(scene) == text
    assert eval(text) == scene


def test_in_jupyter_a_scene_is_a_table_with_units_and_meanings() -> None:
    shown = ConePenetration(in_situ_stress=1e6)._repr_html_()
    for text in (
        "<b>ConePenetration</b>",
        "<td>1000000.0</td><td>Pa</td>",
        "vertical total stress",
    ):
        assert text in shown
    assert "rigidity_index" not in shown


def test_a_run_is_shown_by_its_size_and_how_far_it_is(floating: Scene) -> None:
    simulation = Simulation(floating)
    simulation.advance(3)
    assert repr(simulation).startswith("Simulation(scene Scene, material points 48, memory ")
    assert repr(simulation).endswith(f"step 3, time {simulation.time:.4g} s)")
    assert "<td>material points</td><td>48</td>" in simulation._repr_html_()


def test_the_bar_is_that_of_jupyter_where_it_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    bars = []

    class Bar(tqdm.std.tqdm):
        def __init__(self, **given: Any) -> None:
            super().__init__(**given, disable=True)
            bars.append(given["desc"])

    monkeypatch.setattr(tqdm.auto, "tqdm", Bar)
    GravityColumn(cell_count=2).run(progress=True)
    assert bars == ["gravity_column"]
