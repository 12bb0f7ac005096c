"""Labelled variables of the dataset of a run, and the role of each."""

from collections.abc import Collection
from dataclasses import asdict, dataclass, fields
from typing import Any, Self

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from mpm_warp.errors import SceneError
from mpm_warp.fields.declaration import Parameter, Value
from mpm_warp.fields.flat import flat_values

ROLES = {
    "headline": "the scalar that the scene is run for; one in each dataset",
    "uncertainty": "half width of the interval that holds the true headline with 95 %, or NaN",
    "reason": 'why U is not known, each reason as "word: sentence"; "" where it is',
    "settled": "whether the headline has settled; 0 where the run was too short for it",
    "exact": "an exact value or curve of the variable that the attribute `exact_of` names",
    "error": "a scalar error against an exact solution",
    "measured": "a time, a speed or a size in memory, which differs from run to run",
    "built": "what the scene was built of, whatever its parameters are called",
    "parameter": "what was put in",
}
"""Roles of variables in a dataset; an ordinary result has none."""

SHARED_NAMES = ("displacement", "expansion", "penetration", "step_count", "stretch")
"""Parameters that have the name of a result, as of the axis of its curves."""
PARAMETER_SUFFIX = "_parameter"
NAMES_OF_STUDIES = ("case", "case_key", "case_time", "message", "peak_memory", "status")
"""Names of what a study adds to the results of its cases."""
CHANGING_STRENGTH = "einav_randolph"
"""The law of clay that softens or has a rate effect, by a yield criterion."""


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """The place of a curve in a picture, kept as attributes of its variable.

    Attributes:
        picture: name of the picture, as in the file ``STUDY_picture.png``.
        panel: number of its panel, from the left; curves of one panel share its axes.
        over: the variable on the other axis; "" for that of its last dim.
        divided_by: a scalar or a curve by which it is divided; "" for none.
        downward: whether the other axis goes down the page, as depth does.
        as_marks: whether it is drawn as marks without a line between them.
        to_rest: whether the other axis ends soon after the curves have come to rest.
        slope: the parameter that is the slope of a dashed line from the origin; "" for none.
        joined_over: the parameter whose cases are pieces of one curve; "" for none.

    Raises:
        SceneError: the name of the picture has other characters than letters, digits and "_".

    Example:
        >>> settlement = ([1.0, 1.5], "m", "settlement", Drawn(picture="settlement"))
        >>> curves("time", ([0.1, 0.2], "s", "time"), top=settlement).top.attrs["drawn_picture"]
        'settlement'
    """

    picture: str
    panel: int = 1
    over: str = ""
    divided_by: str = ""
    downward: bool = False
    as_marks: bool = False
    to_rest: bool = False
    slope: str = ""
    joined_over: str = ""

    def __post_init__(self) -> None:
        if not self.picture.isidentifier():  # it is a part of the name of a file
            raise SceneError(f"picture = {self.picture!r}: give it letters, digits and _")

    @property
    def attributes(self) -> dict[str, str | int]:
        """Attributes of the variable, such as ``drawn_panel``; what is not given has none."""
        given = {f"drawn_{name}": value for name, value in asdict(self).items() if value}
        return {name: int(it) if isinstance(it, bool) else it for name, it in given.items()}

    @classmethod
    def of(cls, variable: xr.Variable | xr.DataArray) -> Self | None:
        """The place that a variable has; None if it is in no picture."""
        names = {field.name: f"drawn_{field.name}" for field in fields(cls)}
        given = {name: variable.attrs[it] for name, it in names.items() if it in variable.attrs}
        return cls(**given) if given else None


def variable(
    value: ArrayLike,
    *,
    unit: str | None = "1",
    meaning: str,
    description: str | None = None,
    drawn: Drawn | None = None,
    dims: tuple[str, ...] = (),
    role: str | None = None,
    exact_of: str | None = None,
) -> xr.Variable:
    """A labelled variable.

    Args:
        value: a number or a text, or numbers over `dims`.
        unit: SI unit; "1" for a dimensionless number; None for a text.
        meaning: a few words, fit for the axis of a picture.
        description: how the value was found, if needed.
        drawn: the place of a curve in a picture, if it is in one.
        dims: names of the dimensions.
        role: one of `ROLES`; None for an ordinary result.
        exact_of: name of the variable of which this is the exact value; the role is then "exact".
    """
    labels: dict[str, str | int] = {} if unit is None else {"units": unit}
    labels["long_name"] = meaning
    if description is not None:
        labels["description"] = description
    if exact_of is not None:
        role, labels["exact_of"] = "exact", exact_of
    if role is not None:
        assert role in ROLES, role
        labels["role"] = role
    if drawn is not None:
        labels |= drawn.attributes
    return xr.Variable(dims, np.asarray(value), labels)


Quantity = (
    tuple[ArrayLike, str, str]
    | tuple[ArrayLike, str, str, str | Drawn]
    | tuple[ArrayLike, str, str, str, Drawn]
)
"""Value or values, unit and meaning; then a description, and the place of a curve in a picture."""


def labelled(
    *, dims: tuple[str, ...] = (), role: str | None = None, **quantities: Quantity
) -> dict[str, xr.Variable]:
    """Variables by name, of the same dims and role; ``x_exact`` is the exact value of ``x``.

    Args:
        dims: names of the dimensions; none for scalars.
        role: one of `mpm_warp.results.ROLES`; None for an ordinary result.
        quantities: value or values, unit and meaning; then a description, a `Drawn`, or both.

    Example:
        >>> labelled(role="headline", error=(0.02, "1", "error of the settlement"))["error"].attrs
        {'units': '1', 'long_name': 'error of the settlement', 'role': 'headline'}
    """
    return {
        name: variable(
            value,
            unit=unit,
            meaning=meaning,
            description=next((it for it in others if isinstance(it, str)), None),
            drawn=next((it for it in others if isinstance(it, Drawn)), None),
            dims=dims,
            role=role,
            exact_of=name.removesuffix("_exact") if name.endswith("_exact") else None,
        )
        for name, (value, unit, meaning, *others) in quantities.items()
    }


def curves(axis: str, places: Quantity, **quantities: Quantity) -> xr.Dataset:
    """Curves over an axis with this name and these places, shape [place_count] each.

    Args:
        axis: name of the dimension.
        places: values on the axis, rising, with unit and meaning.
        quantities: values, unit and meaning; then a description, a `Drawn`, or both.

    Example:
        >>> settled = curves(
        ...     "time", ([0.1, 0.2], "s", "time under load"), top=([1.0, 1.5], "m", "settlement")
        ... )
        >>> settled.top.attrs
        {'units': 'm', 'long_name': 'settlement'}
    """
    coords = labelled(dims=(axis,), role=None, **{axis: places})
    return xr.Dataset(labelled(dims=(axis,), role=None, **quantities), coords=coords)


def check_results(results: xr.Dataset) -> None:
    """Check the names, and that each dimension has a variable of its places, each place once.

    Raises:
        SceneError: a name is that of a study; a dimension has no places, or one is repeated.
    """
    for name in NAMES_OF_STUDIES:
        if name in {*results.variables, *results.dims}:
            raise SceneError(f"{name}: studies have this name already; give the result another")
    for dim in results.dims:
        if dim not in results.variables:
            raise SceneError(f"{dim}: is a dimension without a variable that gives its places")
        places, counts = np.unique(results[dim].values, return_counts=True)
        if (counts > 1).any():
            raise SceneError(
                f"{dim} = {places[counts.argmax()]} was recorded {counts.max()} times: take fewer "
                "samples, as a step may pass several moments, or none where nothing has moved"
            )


def stored_name(parameter: str, results: Collection[object]) -> str:
    """The name of a parameter in a dataset: ``<name>_parameter`` if a result has its name.

    One of `SHARED_NAMES` always has the longer name, so that the dataset of a failed run has the
    same names. Dimensions are results too.
    """
    is_shared = parameter in SHARED_NAMES or parameter in results
    return f"{parameter}{PARAMETER_SUFFIX}" if is_shared else parameter


def material_as_built(material: str, law: str) -> str:
    """The stored value of the parameter `material`: the law built, if it differs.

    The law is "" if nothing was built. In clay whose strength changes the law is
    `CHANGING_STRENGTH`, and the parameter names its criterion.
    """
    return material if law in ("", material, CHANGING_STRENGTH) else law


def parameter_variables(scene: Any, results: Collection[object]) -> dict[str, xr.Variable]:
    """All parameters of a scene as variables with the role "parameter", by :func:`stored_name`.

    A number that is not given, or replaced by other parameters, is NaN; such a text is "".
    """
    given = flat_values(scene)
    replaced = set(scene.replaced({name: value for name, (_, value) in given.items()}))
    return {
        stored_name(name, results): variable(
            _stored(None if name in replaced else value, definition),
            unit=None if definition.kind is str else definition.unit,
            meaning=name.rpartition(".")[2].replace("_", " "),
            description=f"{definition.meaning}; {definition.allowed}",
            role="parameter",
        )
        for name, (definition, value) in given.items()
    }


def _stored(value: Value | None, definition: Parameter) -> Value:
    if value is None:
        return "" if definition.kind is str else np.nan
    return value
