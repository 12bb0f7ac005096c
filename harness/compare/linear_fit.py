"""A linear least-squares fit, and what it says of cases that it has not seen."""

from typing import NamedTuple

import numpy as np

from mpm_warp.grid.fitted import Floats

SINGULAR = 1e-9
"""Singular values below this share of the greatest count as 0."""


class LinearFit(NamedTuple):
    """A fit of values by columns of a matrix, without a constant of its own."""

    weights: Floats  # of the columns
    left_out: Floats  # error at each case of the fit to all others

    def explained(self, values: Floats) -> float:
        """The share of the variance of `values` that it explains in cases left out, 0 to 1."""
        total = float(values.var())
        return max(0.0, 1.0 - float(np.mean(self.left_out**2)) / total) if total > 0.0 else 1.0


def linear_fit(matrix: Floats, values: Floats) -> LinearFit:
    """Fit values, shape [cases], by a matrix, [cases, columns]; columns may depend on others."""
    directions, sizes, rows = np.linalg.svd(matrix, full_matrices=False)
    kept = sizes > SINGULAR * sizes.max(initial=0.0)
    directions = directions[:, kept]
    shares = directions.T @ values
    leverage = np.linalg.norm(directions, axis=1) ** 2
    residual = values - directions @ shares
    left_out = residual / np.maximum(1.0 - leverage, SINGULAR)
    return LinearFit(rows[kept].T @ (shares / sizes[kept]), left_out)


def shared_variance(columns: Floats, others: Floats) -> float:
    """The greatest share, 0 to 1, of the variance of a sum of columns that others explain.

    Both have the shape [cases, :] and columns of mean 0. It is the square of the first canonical
    correlation.
    """
    own, theirs = (
        directions[:, sizes > SINGULAR * sizes.max(initial=0.0)]
        for directions, sizes, _ in (
            np.linalg.svd(it, full_matrices=False) for it in (columns, others)
        )
    )
    return float(np.linalg.norm(own.T @ theirs, ord=2) ** 2) if own.size and theirs.size else 0.0
