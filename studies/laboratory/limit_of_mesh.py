"""How far the limit of fine cells depends on the form of the law of the mesh.

    N(h) = N0 + a f(h) + b g(h)

The forms (f, g) of `FORMS` fit the cases of studies/mesh_error.csv about equally well, each clay on
its own, and have different limits N0. They are weighted by their likelihood, with the noise of a
case and without a choice between them. The half width is that which holds 95 % of the weight about
the limit of the law that corrects cone factors. It does not shrink with the cells.

Cells twice as wide as high (studies/mesh_error_wide.csv) have errors of another size and sign. A
limit that both families share, each with its own a and b, is printed beside that of square cells,
with the sum of squares of the residuals over their deviations, alone and in common: it rises where
the families contradict each other.

    python -m studies.laboratory.limit_of_mesh
"""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mpm_warp.fields.plain_numbers import numbers_by_column
from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty import laws

STUDIES = Path(__file__).parent.parent
SQUARE, WIDE = STUDIES / "mesh_error.csv", STUDIES / "mesh_error_wide.csv"
FORMS: dict[str, tuple[Callable[[Floats], Floats], ...]] = {
    "h, h^1.5": (lambda h: h, lambda h: h**1.5),
    "h, h^1.7": (lambda h: h, lambda h: h**1.7),
    "h, h^2": (lambda h: h, lambda h: h**2.0),
    "h^0.8, h^1.6": (lambda h: h**0.8, lambda h: h**1.6),
    "h, h ln h": (lambda h: h, lambda h: h * np.log(h)),
}
NOISE, SCATTER = 0.005, 0.5 * laws.EFFECTS["noise"].half_width
"""Standard deviation of a cone factor: of rounding and time steps; times h, of points in cells."""
CONFIDENCE = 0.95


class Family(NamedTuple):
    """Meshes of one shape of cells in one clay, each array of shape [n]."""

    sizes: Floats  # height of the cells over the radius of the cone
    factors: Floats  # as simulated

    @property
    def deviations(self) -> Floats:
        """Standard deviations of the factors."""
        return np.hypot(NOISE, SCATTER * self.sizes)

    @property
    def without_growth(self) -> Floats:
        """The factors without the known effect of the growth of the cells."""
        measures = [laws.growth_measure(it, laws.GROWTH_OF_MESHES) for it in self.sizes.tolist()]
        return self.factors - laws.EFFECTS["growth"].size * np.array(measures)


class Fit(NamedTuple):
    """A limit that families share, each with its own coefficients, by one form."""

    limit: float
    squares: float  # of residuals over their deviations, summed


class Limits(NamedTuple):
    """The limit of one clay and roughness by all forms."""

    by_law: float  # N0 of the law that corrects cone factors
    alone: dict[str, Fit]  # of square cells, by form
    together: dict[str, Fit]  # of both families; empty where one was measured

    @property
    def weights(self) -> dict[str, float]:
        """Likelihood of each form on square cells; their sum is 1."""
        least = min(fit.squares for fit in self.alone.values())
        likelihoods = {it: math.exp(0.5 * (least - fit.squares)) for it, fit in self.alone.items()}
        return {it: own / sum(likelihoods.values()) for it, own in likelihoods.items()}

    @property
    def half_width(self) -> float:
        """That which holds 95 % of the weight about the limit of the law."""
        differences = {it: abs(fit.limit - self.by_law) for it, fit in self.alone.items()}
        rising = sorted(differences, key=lambda form: differences[form])
        held = np.cumsum([self.weights[form] for form in rising])
        return float(np.interp(CONFIDENCE, held, [differences[form] for form in rising]))


def families(path: Path) -> dict[tuple[float, float], Family]:
    """The meshes of a file of readings, by rigidity index and adhesion factor."""
    index, adhesion, cells, factors = np.array(
        [*numbers_by_column(path.read_text(encoding="utf-8")).values()]
    )
    face = math.sqrt(3.0)  # height of the face of a cone of 60 degrees over its radius
    sizes = face / np.round(face * cells)
    found = {}
    for clay in sorted({*zip(index.tolist(), adhesion.tolist(), strict=True)}):
        own = (index == clay[0]) & (adhesion == clay[1])
        found[clay] = Family(sizes[own], factors[own])
    return found


def fitted(form: str, shared: Sequence[Family]) -> Fit:
    """The limit of families by a form, by weighted least squares."""
    terms = FORMS[form]
    system = np.zeros((sum(it.sizes.size for it in shared), 1 + len(terms) * len(shared)))
    system[:, 0], row = 1.0, 0
    for place, family in enumerate(shared):
        rows = slice(row, row := row + family.sizes.size)
        for column, term in enumerate(terms, 1 + len(terms) * place):
            system[rows, column] = term(family.sizes)
    deviations = np.concatenate([it.deviations for it in shared])
    factors = np.concatenate([it.without_growth for it in shared]) / deviations
    found, *_ = np.linalg.lstsq(system / deviations[:, None], factors)
    residuals = factors - system @ found / deviations
    return Fit(float(found[0]), float(residuals @ residuals))


def limits() -> dict[tuple[float, float], Limits]:
    """The limits of all clays measured, by rigidity index and adhesion factor."""
    wide = families(WIDE)
    found = {}
    for clay, square in families(SQUARE).items():
        both = [square, wide[clay]] if clay in wide else []
        found[clay] = Limits(
            _by_law(clay, square),
            {form: fitted(form, [square]) for form in FORMS},
            {form: fitted(form, both) for form in FORMS} if both else {},
        )
    return found


def _by_law(clay: tuple[float, float], square: Family) -> float:
    """N0 of the law that corrects cone factors."""
    errors = [
        laws.mesh_error(
            rigidity_index=clay[0],
            adhesion_factor=clay[1],
            cell_size=size,
            cell_growth=laws.GROWTH_OF_MESHES,
        )
        for size in square.sizes.tolist()
    ]
    corrected = square.factors - np.array(errors, dtype=float)
    return float(np.average(corrected, weights=square.deviations**-2.0))


def main() -> None:
    """Print a row for each clay: its limit by the law, the half width, and what each form gives."""
    print("Ir, adhesion      N0  half width  " + "  ".join(f"{form:>14}" for form in FORMS))
    for (index, adhesion), it in limits().items():
        cells = [f"{it.alone[f].limit - it.by_law:+.3f} ({it.weights[f]:.2f})" for f in FORMS]
        row = "  ".join(f"{text:>14}" for text in cells)
        print(f"{index:4g}, {adhesion:<8g} {it.by_law:6.3f}  {it.half_width:10.3f}  {row}")
        for form, (limit, squares) in it.together.items():
            alone = it.alone[form].squares + fitted(form, [families(WIDE)[index, adhesion]]).squares
            print(f"{'with wide cells':>34}  {form:>14}  {limit - it.by_law:+.3f}", end="")
            print(f"  squares {alone:.1f} alone, {squares:.1f} in common")


if __name__ == "__main__":
    main()
