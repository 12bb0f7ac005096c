"""A scene is composed of groups of parameters, and as flat as if they were its own."""

import dataclasses
import inspect
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest

from mpm_warp import CatalogueScene, ConePenetration, GravityColumn, Group, Sounding, Tresca
from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.fields.declaration import Derived, group, own_parameters_of, parameter
from mpm_warp.fields.flat import values_of
from mpm_warp.provenance import sources_of
from mpm_warp.scenes import scene_class, scene_names

WRONG = "no_such_name"


@dataclass(frozen=True, kw_only=True)
class Own(Group):
    """A group of a user."""

    whole: float = parameter(1.0, "a length", unit="m", maximum=10)
    half: float = parameter(None, "default: half of it", unit="m")

    def derived(self) -> dict[str, float]:
        return {"half": 0.5 * self.whole}


@dataclass(frozen=True, kw_only=True)
class OwnScene(CatalogueScene):
    """A scene of a user, who makes a dataclass of it as of any other."""

    summary: ClassVar[str] = "a scene of one's own"

    own: Own = group()
    count: int = parameter(3, "a number")
    sum: float = parameter(None, "default: whole and half")

    def derived(self) -> dict[str, float]:
        return {"sum": self.own.whole + self.own.half}

    def build(self) -> Any: ...

    def record(self, simulation: Any, progress: Any) -> Any: ...

    @property
    def broken(self) -> float:
        return float(getattr(self.own, WRONG))


@dataclass(frozen=True, kw_only=True)
class OwnCone(ConePenetration):
    summary = "cone test with a group of one's own"

    own: Own = group()


def test_parameters_of_groups_stand_flat_in_their_order() -> None:
    assert list(own_parameters_of(OwnScene)) == ["whole", "half", "count", "sum"]
    assert values_of(OwnScene(whole=4.0)) == {"whole": 4.0, "half": 2.0, "count": 3, "sum": 6.0}
    assert list(own_parameters_of(OwnCone))[-2:] == ["whole", "half"]
    assert repr(OwnScene(whole=4.0, count=3)) == "OwnScene(whole=4.0)"


@pytest.mark.parametrize(
    ("changes", "half", "total"),
    [
        ({}, 2.0, 6.0),
        ({"whole": 6.0}, 3.0, 9.0),
        ({"half": 1.0}, 1.0, 5.0),
        ({"own": Own(whole=2.0)}, 1.0, 3.0),
        ({"own": Own(whole=2.0), "whole": 6.0}, 3.0, 9.0),
        ({"own": Own(whole=2.0).kept, "whole": 6.0}, 1.0, 7.0),
    ],
)
def test_what_is_derived_is_derived_again_in_its_group_and_beside_it(
    changes: dict[str, Any], half: float, total: float
) -> None:
    made = replace(OwnScene(whole=4.0), **changes)
    assert (made.half, made.own.half, made.sum) == (half, half, total)
    assert isinstance(made.sum, Derived)


@pytest.mark.parametrize(
    ("kind", "given", "message"),
    [
        (OwnScene, {"whole": 11.0}, "whole = 11.0 is not allowed: must be a number <= 10"),
        (OwnScene, {"hole": 1.0}, "unknown parameter 'hole'; did you mean 'whole'"),
        (OwnScene, {"own": 3}, "own = 3 must be of type Own"),
        (OwnCone, {"material": "tresk"}, "did you mean 'tresca'"),
        (OwnCone, {"rate_factor": 0.1}, "needs reference_strain_rate"),
    ],
)
def test_a_refusal_is_that_of_a_flat_parameter(
    kind: type[CatalogueScene], given: dict[str, Any], message: str
) -> None:
    with pytest.raises((ParameterError, SceneError), match=message):
        kind(**given)


@pytest.mark.parametrize(("name", "lacks"), [(WRONG, OwnScene), ("broken", Own)])
def test_an_attribute_that_is_not_there_is_named_with_whose_it_would_be(
    name: str, lacks: type
) -> None:
    with pytest.raises(AttributeError, match=f"'{lacks.__name__}' object has no .*{WRONG}"):
        getattr(OwnScene(), name)


def test_two_groups_of_a_scene_have_no_parameter_of_one_name() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Twice(OwnScene):
        another: Own = group()

    with pytest.raises(TypeError, match="Twice has two parameters 'half'"):
        Twice()


def test_a_scene_or_a_law_without_its_decorator_is_told_of_it() -> None:
    """Its fields would be none, without a word."""

    class Forgotten(OwnScene):
        size: int = parameter(8, "size")

    class Law(Tresca):
        angle: float = parameter(8.0, "angle")

    for make in (Forgotten, lambda: Forgotten(size=3), Law):
        with pytest.raises(TypeError, match=r"is no field yet: put @dataclass\(.*above class"):
            make()


def test_a_record_without_results_is_told_of_it() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Silent(GravityColumn):
        def record(self, simulation: Any, progress: Any) -> Any:
            return None

    with pytest.raises(SceneError, match=r"Silent.record\(\) = None must be of type Dataset"):
        Silent(cell_count=2).run()


def test_a_scene_without_a_summary_is_told_of_it_before_it_runs() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Nameless(CatalogueScene):
        def build(self) -> Any:
            raise AssertionError("not before the summary is asked for")

        def record(self, simulation: Any, progress: Any) -> Any:
            raise AssertionError("not before the summary is asked for")

    with pytest.raises(SceneError, match=r"Nameless.summary = None must be of type str"):
        Nameless().run()


def test_a_group_of_one_scene_may_be_given_to_another() -> None:
    sounding = Sounding(cone_radius=0.02, domain_below=20.0)
    cone = OwnCone(domain=sounding.domain, clay=ConePenetration(rigidity_index=400.0).clay)
    assert (cone.domain_below, cone.rigidity_index) == (20.0, 400.0)
    assert cone.domain_radius == 80.0 != sounding.domain_radius
    assert OwnCone(domain=sounding.domain.kept).domain_radius == sounding.domain_radius
    assert "tests " in f"{sources_of(cone, ())} "


@pytest.mark.parametrize("name", scene_names())
def test_at_most_two_classes_stand_between_a_scene_and_the_base_of_all(name: str) -> None:
    between = inspect.getmro(scene_class(name))[1:].index(CatalogueScene)
    assert between <= 2
    assert dataclasses.is_dataclass(scene_class(name))
