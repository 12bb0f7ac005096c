"""How far the limit of fine cells depends on the form of the law of the mesh.

    N(h) = N0 + a f(h) + b g(h)

The forms (f, g) of `FORMS` fit the cases of studies/mesh_error.csv about equally well, each clay on
its own, and have different limits N0. They are weighted by their likelihood, with the noise of a
case and without a choice between them. The half width is that which holds 95 % of the weight about
the limit of the law that corrects cone factors. It does not shrink with the cells.

    python -m studies.laboratory.limit_of_mesh
"""

import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mpm_warp.fields.plain_numbers import numbers_by_column
from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty import laws

MEASURED = Path(__file__).parent.parent / "mesh_error.csv"
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


class Limit(NamedTuple):
    """The limit of one clay and roughness by all forms."""

    by_law: float  # N0 of the law that corrects cone factors
    differences: dict[str, float]  # N0 of each form less that, by form
    weights: dict[str, float]  # likelihood of each form; their sum is 1

    @property
    def half_width(self) -> float:
        """That which holds 95 % of the weight about the limit of the law."""
        rising = sorted(self.differences, key=lambda form: abs(self.differences[form]))
        held = np.cumsum([self.weights[form] for form in rising])
        sizes = [abs(self.differences[form]) for form in rising]
        return float(np.interp(CONFIDENCE, held, sizes))


def limits() -> dict[tuple[float, float], Limit]:
    """The limits of all clays measured, by rigidity index and adhesion factor."""
    columns = numbers_by_column(MEASURED.read_text())
    cases = np.array([*columns.values()], dtype=float).T
    clays = sorted({(index, adhesion) for index, adhesion, *_ in cases.tolist()})
    return {clay: _limit(clay, cases[np.all(cases[:, :2] == clay, axis=1), 2:]) for clay in clays}


def _limit(clay: tuple[float, float], cases: Floats) -> Limit:
    """The limit from cells per radius and cone factor of each case, shape [n, 2]."""
    cells, factors = cases.T
    face = math.sqrt(3.0)  # height of the face of a cone of 60 degrees over its radius
    sizes = face / np.round(face * cells)
    deviations = np.hypot(NOISE, SCATTER * sizes)
    of_law = [
        laws.mesh_error(
            rigidity_index=clay[0],
            adhesion_factor=clay[1],
            cell_size=size,
            cell_growth=laws.GROWTH_OF_MESHES,
        )
        for size in sizes.tolist()
    ]
    by_law = float(np.average(factors - of_law, weights=deviations**-2.0))
    of_growth = [laws.growth_measure(size, laws.GROWTH_OF_MESHES) for size in sizes.tolist()]
    without_growth = factors - laws.EFFECTS["growth"].size * np.array(of_growth)
    differences, squares = {}, {}
    for form, terms in FORMS.items():
        system = np.stack([np.ones_like(sizes), *(term(sizes) for term in terms)], axis=1)
        found, *_ = np.linalg.lstsq(system / deviations[:, None], without_growth / deviations)
        residuals = (without_growth - system @ found) / deviations
        differences[form], squares[form] = float(found[0]) - by_law, float(residuals @ residuals)
    least = min(squares.values())
    likelihoods = {form: math.exp(0.5 * (least - own)) for form, own in squares.items()}
    whole = sum(likelihoods.values())
    return Limit(by_law, differences, {form: own / whole for form, own in likelihoods.items()})


def main() -> None:
    """Print a row for each clay: its limit by the law, the half width, and what each form gives."""
    print("Ir, adhesion      N0  half width  " + "  ".join(f"{form:>14}" for form in FORMS))
    for (index, adhesion), it in limits().items():
        forms = (f"{it.differences[form]:+.3f} ({it.weights[form]:.2f})" for form in FORMS)
        row = "  ".join(f"{text:>14}" for text in forms)
        print(f"{index:4g}, {adhesion:<8g} {it.by_law:6.3f}  {it.half_width:10.3f}  {row}")


if __name__ == "__main__":
    main()
