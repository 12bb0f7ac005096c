"""Structural mutants of results: what a file may be that somebody else has made or changed."""

from __future__ import annotations

from collections.abc import Callable, Hashable

import numpy as np
import xarray as xr

Random = np.random.Generator
Mutation = Callable[[xr.Dataset, Random], xr.Dataset]


def _one(names: object, random: Random) -> Hashable:
    listed = list(names)  # type: ignore[call-overload]
    return listed[random.integers(len(listed))]


def _variable_missing(dataset: xr.Dataset, random: Random) -> xr.Dataset:
    return dataset.drop_vars(_one(dataset.variables, random))


def _variable_renamed(dataset: xr.Dataset, random: Random) -> xr.Dataset:
    return _with_names(dataset, {_one(dataset.variables, random): "renamed"}, {})


def _dim_renamed(dataset: xr.Dataset, random: Random) -> xr.Dataset:
    return _with_names(dataset, {}, {_one(dataset.dims, random): "renamed"})


def _dims_of_one_renamed(dataset: xr.Dataset, random: Random) -> xr.Dataset:
    name = _one(dataset.data_vars, random)
    variable = dataset[name].variable
    other = variable.copy()
    other.dims = tuple(f"other_{dim}" for dim in variable.dims)
    return dataset.assign({name: other})


def _with_names(
    dataset: xr.Dataset, names: dict[Hashable, str], dims: dict[Hashable, str]
) -> xr.Dataset:
    variables = {}
    for name, variable in dataset.variables.items():
        other = variable.to_base_variable().copy()
        other.dims = tuple(dims.get(dim, dim) for dim in other.dims)
        variables[names.get(name, name)] = other
    coordinates = {names.get(name, name) for name in dataset.coords} & variables.keys()
    return xr.Dataset(
        {name: it for name, it in variables.items() if name not in coordinates},
        {name: variables[name] for name in coordinates},
        dataset.attrs,
    )


def _variable_retyped(dataset: xr.Dataset, random: Random) -> xr.Dataset:
    name = _one(dataset.variables, random)
    variable = dataset[name].variable.to_base_variable()
    fill = [7, 0.5, "text", "", True, np.int8(3), np.nan, -1e300][random.integers(8)]
    values = np.full(variable.shape, fill)
    other = xr.Dataset({"it": (variable.dims, values, variable.attrs)})["it"].variable
    return _replaced(dataset, name, other)


def _variable_resized(dataset: xr.Dataset, random: Random) -> xr.Dataset:
    name = _one(dataset.variables, random)
    variable = dataset[name].variable.to_base_variable()
    how = random.integers(4)
    if how == 0 or variable.ndim == 0:
        other = variable.expand_dims({"more": 3}).copy()
    elif how == 1:
        other = variable[(0,) * variable.ndim]
    elif how == 2:
        other = variable.transpose(*variable.dims[::-1]).expand_dims({"more": 1}).copy()
    else:
        other = xr.Variable((), 1.0, variable.attrs)
    return _replaced(dataset, name, other)


def _dim_resized(dataset: xr.Dataset, random: Random) -> xr.Dataset:
    dim = _one(dataset.dims, random)
    size = dataset.sizes[dim]
    places = [[0], [*range(size), 0], list(range(size))[::-1], []][random.integers(4)]
    return dataset.isel({dim: places})


def _replaced(dataset: xr.Dataset, name: Hashable, other: xr.Variable) -> xr.Dataset:
    is_coordinate = name in dataset.coords and name not in other.dims
    left = dataset.drop_vars(name)
    return left.assign_coords({name: other}) if is_coordinate else left.assign({name: other})


def _attribute_changed(dataset: xr.Dataset, random: Random) -> xr.Dataset:
    dataset = dataset.copy()
    names = [None, *dataset.variables]
    name = names[random.integers(len(names))] if random.random() < 0.7 else None
    attributes = dataset.attrs if name is None else dataset[name].attrs
    if not attributes:
        return dataset
    key = _one(attributes, random)
    value = attributes.pop(key)
    how = random.integers(8)
    if how == 0:
        return dataset
    if how == 1:
        attributes["renamed"] = value
        return dataset
    attributes[key] = ["", 3, -0.5, [1.0, 2.0], "no such thing", "{\x1b[31m\n"][how - 2]
    return dataset


def _attribute_added(dataset: xr.Dataset, random: Random) -> xr.Dataset:
    dataset = dataset.copy()
    added = [
        *[("role", role) for role in ("headline", "exact", "error", "parameter", "reference", 3)],
        *[("limit", limit) for limit in ("wide", [1.0, 2.0], np.nan)],
        *[("exact_of", "nothing"), ("coordinates", "nothing here"), ("scale_factor", "large")],
        *[("units", "days since 1900-01-01"), ("units", 3), ("long_name", [1, 2])],
        *[("missing_value", 0.0), ("add_offset", 1e300), ("dtype", "timedelta64[ns]")],
    ]
    key, value = added[random.integers(len(added))]
    dataset[_one(dataset.variables, random)].attrs[key] = value
    return dataset


MUTATIONS: tuple[Mutation, ...] = (
    _variable_missing,
    _variable_renamed,
    _variable_retyped,
    _variable_resized,
    _dim_renamed,
    _dims_of_one_renamed,
    _dim_resized,
    _attribute_changed,
    _attribute_added,
)


def mutant(dataset: xr.Dataset, seed: int) -> tuple[str, xr.Dataset]:
    """A mutant of a result and the kind of it; the kinds take turns."""
    mutation = MUTATIONS[seed % len(MUTATIONS)]
    return mutation.__name__.strip("_"), mutation(dataset, np.random.default_rng(seed))
