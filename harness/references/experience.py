"""Factors of cone tests measured in the field, as bands.

Measured factors include effects that the ideal cone factor does not have (:data:`HOLDS`). So a band
is shown beside a result but is not a reference: no deviation from it is computed, and a result need
not lie in it. A new band is one new entry in :data:`EXPERIENCE`.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

HOLDS = (
    "rate effects, softening, anisotropy of strength and stress, and disturbance of the samples: "
    "the ideal cone factor has none of them"
)
"""Effects that measured factors include, in words."""
COMPRESSION = "peak in triaxial compression, consolidated anisotropically"
"""The meaning of su in all entries."""
BESIDE_COMPRESSION = (
    "direct shear has 0.6 to 0.9 of the strength in triaxial compression, triaxial extension 0.35 "
    "to 0.5; the simulation's su is that in pure shear, which direct shear comes nearest to"
)
"""How other strengths compare with that in compression."""


class Factor(StrEnum):
    """Kind of factor: u2 is the pore pressure behind the shoulder, u0 the one before the test."""

    RESISTANCE = "Nkt"
    PORE_PRESSURE = "N_du"

    @property
    def definition(self) -> str:
        """The factor as a formula."""
        over_su = {"Nkt": "(qt - sigma_v0) / su", "N_du": "(u2 - u0) / su"}
        return f"{self} = {over_su[self]}"


class Input(NamedTuple):
    """A property of the clay in a formula, with the range that a band covers."""

    symbol: str
    low: float
    high: float
    chosen: str  # where the range comes from

    @property
    def span(self) -> str:
        """The range in words."""
        return f"{self.symbol} {self.low:g} to {self.high:g}"


@dataclass(frozen=True, kw_only=True)
class Experience:
    """One band of factors measured in the field."""

    id: str  # name in study definitions and in the variables of a result
    label: str  # authors and year, for pictures
    factor: Factor = Factor.RESISTANCE
    formula: str
    evaluate: Callable[..., float]  # takes the inputs in their order; monotonic in each
    inputs: tuple[Input, ...]
    clays: str  # the tested clays
    source: str  # where it was published
    how_known: str  # where formula and ranges were taken from
    # relative scatter about the formula; it was reported for su and is used for the factor; 0: none
    scatter: float = 0.0
    strength: str = COMPRESSION  # meaning of su

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest factor over the ranges of the inputs, with scatter."""
        corners = itertools.product(*((given.low, given.high) for given in self.inputs))
        values = [self.evaluate(*corner) for corner in corners]
        return min(values) * (1.0 - self.scatter), max(values) * (1.0 + self.scatter)

    @property
    def band(self) -> str:
        """Factor and bounds in words."""
        low, high = self.bounds
        return f"{self.factor} {low:.1f} to {high:.1f}"

    @property
    def spans(self) -> str:
        """Ranges of the inputs, and scatter, in words."""
        scatter = f", +-{100 * self.scatter:.0f} %" if self.scatter else ""
        return ", ".join(given.span for given in self.inputs) + scatter


_KARLSRUD = "Karlsrud, Lunne, Kort & Strandvik 2005, 16th ICSMGE Osaka, CPTU correlations for clays"
_KARLSRUD_KNOWN = "formula, scatter and range of OCR at second hand; the abstract was read"
_LARGER_SCATTER = f"{_KARLSRUD_KNOWN}; of a scatter of 10 to 15 % the larger is taken"
_MAYNE = (
    "Mayne & Peuchen 2018, Cone Penetration Testing 2018, Evaluation of CPTU Nkt cone factor for "
    "undrained strength of clays"
)
_BLOCK_SAMPLES = "soft to medium stiff marine clays, 17 sites, block samples of high quality"
_OCR = Input("OCR", 1.2, 6.3, "of the clays tested, at second hand")
_PLASTICITY = Input("Ip", 10.0, 50.0, "percent; of the clays tested, by the abstract")
_BQ_CHOSEN = "chosen here, for soft to firm clay; Bq = (u2 - u0) / (qt - sigma_v0)"
_BQ = Input("Bq", 0.4, 1.0, _BQ_CHOSEN)
_MEASURED = Input("Nkt", 8.0, 25.0, "of the clays tested, by the abstract")

EXPERIENCE: tuple[Experience, ...] = (
    Experience(
        id="karlsrud_2005",
        label="Karlsrud et al. 2005",
        formula="7.8 + 2.5 log10 OCR + 0.082 Ip",
        evaluate=lambda ocr, ip: 7.8 + 2.5 * math.log10(ocr) + 0.082 * ip,
        inputs=(_OCR, _PLASTICITY),
        scatter=0.30,
        clays=f"{_BLOCK_SAMPLES}, sensitivity below 15",
        source=_KARLSRUD,
        how_known=_KARLSRUD_KNOWN,
    ),
    Experience(
        id="karlsrud_2005_sensitive",
        label="Karlsrud et al. 2005, sensitive clays",
        formula="8.5 + 2.5 log10 OCR",
        evaluate=lambda ocr: 8.5 + 2.5 * math.log10(ocr),
        inputs=(_OCR,),
        scatter=0.15,
        clays=f"{_BLOCK_SAMPLES}, sensitivity above 15",
        source=_KARLSRUD,
        how_known=_KARLSRUD_KNOWN,
    ),
    Experience(
        id="mayne_peuchen_2018",
        label="Mayne & Peuchen 2018",
        formula="10.5 - 4.6 ln(Bq + 0.1)",
        evaluate=lambda bq: 10.5 - 4.6 * math.log(bq + 0.1),
        inputs=(_BQ,),
        clays="62 clays, soft to hard and fissured, 407 tests",
        source=_MAYNE,
        how_known="formula at second hand, without its scatter; the abstract was read",
    ),
    Experience(
        id="mayne_peuchen_2018_all",
        label="Mayne & Peuchen 2018, all clays",
        formula="Nkt as measured",
        evaluate=lambda measured: measured,
        inputs=(_MEASURED,),
        clays="62 clays, soft to hard and fissured, 407 tests",
        source=_MAYNE,
        how_known="the abstract was read",
    ),
    Experience(
        id="karlsrud_2005_pore_pressure",
        label="Karlsrud et al. 2005",
        factor=Factor.PORE_PRESSURE,
        formula="6.9 - 4.0 log10 OCR + 0.07 Ip",
        evaluate=lambda ocr, ip: 6.9 - 4.0 * math.log10(ocr) + 0.07 * ip,
        inputs=(_OCR, _PLASTICITY),
        scatter=0.15,
        clays=f"{_BLOCK_SAMPLES}, sensitivity below 15",
        source=_KARLSRUD,
        how_known=_LARGER_SCATTER,
    ),
    Experience(
        id="karlsrud_2005_pore_pressure_sensitive",
        label="Karlsrud et al. 2005, sensitive clays",
        factor=Factor.PORE_PRESSURE,
        formula="9.8 - 4.5 log10 OCR",
        evaluate=lambda ocr: 9.8 - 4.5 * math.log10(ocr),
        inputs=(_OCR,),
        scatter=0.15,
        clays=f"{_BLOCK_SAMPLES}, sensitivity above 15",
        source=_KARLSRUD,
        how_known=_LARGER_SCATTER,
    ),
)
