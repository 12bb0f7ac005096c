"""The clay of a scene: what is chosen, what has to be given together, and the time it lives in."""

import pytest

from mpm_warp.errors import ParameterError
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.tresca import Tresca
from mpm_warp.scenes.material.material_point import MaterialPoint

CLAY = {"density": 1700.0, "strength": 1e4}


def test_clay_whose_strength_nothing_changes_is_perfectly_plastic() -> None:
    """Whatever reference and ductility are: they belong to nothing then."""
    scene = MaterialPoint(reference_strain_rate=0.1, ductility=10.0)
    assert scene.clay_with(speed_up=3.0, **CLAY) == Tresca(
        shear_modulus=1e6, poissons_ratio=0.49, **CLAY
    )


def test_strain_rates_are_those_of_reality() -> None:
    """A run that is three times as fast takes three times the rate for that of reference."""
    scene = MaterialPoint(rate_factor=0.1, reference_strain_rate=0.1)
    clay = scene.clay_with(speed_up=3.0, **CLAY)
    assert isinstance(clay, EinavRandolph)
    assert clay.reference_strain_rate == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"rate_factor": 0.1}, "rate_factor = 0.1 needs reference_strain_rate, in 1/s: give both"),
        ({"remoulded_strength_ratio": 0.2}, "remoulded_strength_ratio = 0.2 needs ductility, the"),
        ({"remoulded_strength_ratio": 0.2, "ductility": 0.01}, "ductility = 0.01 is too brittle"),
    ],
)
def test_what_no_clay_is_like_is_refused_in_one_line(given: dict[str, float], message: str) -> None:
    with pytest.raises(ParameterError) as refused:
        MaterialPoint(**given)
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)
