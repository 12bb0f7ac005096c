"""A scene in one clay, and the stress of the ground before a test."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.fields.checked import Group
from mpm_warp.fields.declaration import Derived, group, own_parameters_of, parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import Material
from mpm_warp.scenes.catalogue_scene import CatalogueScene
from mpm_warp.scenes.clay import Clay


@dataclass(frozen=True, kw_only=True)
class StressAtRest(Group):
    """The stress of the ground before a test, in excess of the vertical stress."""

    stress_anisotropy: float = parameter(
        Derived(0.0),
        "stress anisotropy Delta in the ground before: vertical less horizontal stress over 2 su",
        above=-1,
        below=1,
    )

    def at_rest(self, strength: float) -> Floats:
        """Initial stress (rr, zz, rz, tt) in clay of a strength su [Pa], shape [4]."""
        return 2.0 * self.stress_anisotropy * strength * np.array([1.0, 0.0, 0.0, 1.0])


@dataclass(frozen=True, kw_only=True, init=False)
class ClayScene(CatalogueScene):
    """A scene in one clay.

    Raises:
        mpm_warp.errors.ParameterError: on construction, also where the law does not allow a value
            or the stress at rest.
    """

    clay: Clay = group()

    def derived(self) -> Mapping[str, float]:
        """The stress anisotropy of a law that gives K0."""
        anisotropy = self.clay.own_anisotropy
        if anisotropy is None:
            return {}
        if "stress_anisotropy" not in own_parameters_of(type(self)):
            raise ParameterError(
                "material",
                "this scene starts from stresses that are equal in all directions: give "
                "isotropic_overconsolidation_ratio, without K0",
            )
        return {"stress_anisotropy": anisotropy}

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check_soil()

    def check_soil(self) -> None:
        """Refuse values that the law does not allow."""
        try:
            _ = self.soil
        except SceneError as refusal:
            key = "ductility" if self.clay.is_criterion else "material"
            raise ParameterError(key, str(refusal)) from None

    @property
    @abstractmethod
    def soil(self) -> Material:
        """The clay as it is simulated, made by `Clay.built`."""

    @property
    def stress_at_rest(self) -> Floats:
        """Initial stress (rr, zz, rz, tt) in excess of the vertical stress [Pa], shape [4]."""
        return np.zeros(4)
