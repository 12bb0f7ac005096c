"""Which combinations of values a study runs.

- ``full``: all combinations; the last parameter changes fastest.
- ``one_at_a_time``: a case with the fixed values, then each value of each parameter by itself.
- ``list``: the combinations that the study lists.
- ``latin_hypercube``: random. Each range or distribution is divided into as many equally probable
  intervals as there are samples, and each interval is sampled once.
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from harness.study.distributions import Input
from mpm_warp.fields.checked import check_fields
from mpm_warp.fields.declaration import Parameter, Value, parameter

FULL, ONE_AT_A_TIME, LIST, LATIN_HYPERCUBE = "full", "one_at_a_time", "list", "latin_hypercube"
DESIGNS = {
    FULL: "all combinations of what varies",
    ONE_AT_A_TIME: "one parameter varied at a time",
    LIST: "as they are listed",
    LATIN_HYPERCUBE: "a Latin hypercube",
}
"""The designs, and what each runs, in words."""
VARY_REPLACES_FIXED = (FULL, LATIN_HYPERCUBE)
"""Designs in which a varied parameter needs no fixed value; one at a time most cases have it."""
SPACINGS = ("linear", "logarithmic")
LARGEST_STUDY = 100_000
"""Cases that a study may have; more are a mistake in a list or range."""
LARGEST_SEED = 2**32 - 1

Combination = Mapping[str, Value]
"""The values that the design gives to one case, by parameter name."""


def rounded(number: float) -> float:
    """A number with 12 digits. Later digits differ between machines and would change case keys."""
    return float(f"{number:.12g}")


@dataclass(frozen=True, kw_only=True)
class Range:
    """Numbers from `start` to `stop`, both included, in equal steps or, logarithmic, ratios."""

    start: float
    stop: float
    logarithmic: bool

    def at(self, fraction: float) -> float:
        """The number at a fraction, 0 to 1, of the way from `start` to `stop`; 12 digits."""
        if fraction in (0.0, 1.0):
            return self.stop if fraction else self.start
        if self.logarithmic:
            number = self.start * (self.stop / self.start) ** fraction
        else:
            number = self.start + (self.stop - self.start) * fraction
        return rounded(number)

    def values(self, count: int) -> tuple[float, ...]:
        """`count` evenly spaced numbers; `count` is at least 2."""
        return tuple(self.at(i / (count - 1)) for i in range(count))


@dataclass(frozen=True, kw_only=True)
class Design:
    """How the values of a study are combined."""

    kind: str = parameter(
        FULL, "how varied values are combined", choices=tuple(DESIGNS), key="design"
    )
    samples: int = parameter(None, "cases of a Latin hypercube", minimum=1, maximum=LARGEST_STUDY)
    seed: int = parameter(
        None, "seed of a Latin hypercube's random numbers", minimum=0, maximum=LARGEST_SEED
    )

    def __post_init__(self) -> None:
        check_fields(self)


Variation = tuple[Value, ...] | Range | Input
Variations = Mapping[str, Variation]


def combination_count(design: Design, varied: Variations, listed: Sequence[Combination]) -> int:
    """The number of combinations that :func:`combinations` yields."""
    sizes = [len(values) for values in varied.values() if isinstance(values, tuple)]
    counts = {
        FULL: math.prod(sizes),
        ONE_AT_A_TIME: 1 + sum(sizes),
        LIST: len(listed),
        LATIN_HYPERCUBE: design.samples,
    }
    return counts[design.kind]


def combinations(
    design: Design,
    varied: Variations,
    listed: Sequence[Combination],
    known: Mapping[str, Parameter],
) -> Iterator[Combination]:
    """Yield the combinations of a design in order.

    Args:
        design: how values are combined.
        varied: what varies, by parameter name.
        listed: the combinations of the design ``list``.
        known: the parameters of the scene, which say what type of value each has.
    """
    if design.kind == LIST:
        yield from listed
    elif design.kind == LATIN_HYPERCUBE:
        yield from _latin_hypercube(design, varied, known)
    else:
        values = {name: v for name, v in varied.items() if isinstance(v, tuple)}
        if design.kind == FULL:
            for choice in itertools.product(*values.values()):
                yield dict(zip(values, choice, strict=True))
        else:
            yield {}
            for name, several in values.items():
                for value in several:
                    yield {name: value}


def _latin_hypercube(
    design: Design, varied: Variations, known: Mapping[str, Parameter]
) -> Iterator[Combination]:
    # Imported here because SciPy takes half a second to load, and no other design needs it.
    from scipy.stats.qmc import LatinHypercube

    points = LatinHypercube(len(varied), rng=design.seed).random(design.samples)
    for point in points.tolist():
        yield {
            name: _sampled(values, fraction, known[name].kind)
            for (name, values), fraction in zip(varied.items(), point, strict=True)
        }


def _sampled(values: Variation, fraction: float, kind: type) -> Value:
    if isinstance(values, tuple):
        return values[int(fraction * len(values))]
    if isinstance(values, Input):
        return rounded(values.at(fraction))
    if kind is not int:
        return values.at(fraction)
    # Half a unit more at either end gives the first and the last integer the same probability.
    wide = Range(start=values.start - 0.5, stop=values.stop + 0.5, logarithmic=values.logarithmic)
    return min(max(round(wide.at(fraction)), round(values.start)), round(values.stop))
