"""Which combinations of values a study runs.

Of a full design the last parameter is the fastest. One at a time begins with the fixed values
alone. Of a Latin hypercube each range, and each distribution, has as many equally probable shares
as there are samples, and every share is sampled once.
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from harness.study.distributions import Input
from mpm_warp.parameters import Parameter, Value

FULL, ONE_AT_A_TIME, LIST, LATIN_HYPERCUBE = "full", "one_at_a_time", "list", "latin_hypercube"
DESIGNS = {
    FULL: "all combinations of what varies",
    ONE_AT_A_TIME: "one parameter varied at a time",
    LIST: "as they are listed",
    LATIN_HYPERCUBE: "a Latin hypercube",
}
"""The designs, and the cases of each in words."""
EITHER_FIXED_OR_VARIED = (FULL, LATIN_HYPERCUBE)
"""Designs of which no case has a varied parameter's fixed value; one at a time most cases do."""
SPACINGS = ("linear", "logarithmic")

Combination = Mapping[str, Value]
"""The values that a case has of its own, by name."""


def rounded(number: float) -> float:
    """12 digits: the last ones are not the same on every machine, and they would name the case."""
    return float(f"{number:.12g}")


@dataclass(frozen=True, kw_only=True)
class Range:
    """Numbers from one end to the other, both included; equal ratios where logarithmic."""

    start: float
    stop: float
    logarithmic: bool

    def at(self, fraction: float) -> float:
        """The number at `fraction` of the way, 0 to 1, to 12 digits."""
        if fraction in (0.0, 1.0):
            return self.stop if fraction else self.start
        if self.logarithmic:
            number = self.start * (self.stop / self.start) ** fraction
        else:
            number = self.start + (self.stop - self.start) * fraction
        return rounded(number)

    def values(self, count: int) -> tuple[float, ...]:
        """`count` numbers, 2 or more."""
        return tuple(self.at(i / (count - 1)) for i in range(count))


@dataclass(frozen=True, kw_only=True)
class Design:
    """How values are combined: one of `DESIGNS`; of a Latin hypercube its cases and its seed."""

    kind: str
    samples: int = 0
    seed: int = 0


Variation = tuple[Value, ...] | Range | Input
Variations = Mapping[str, Variation]


def combination_count(design: Design, varied: Variations, listed: Sequence[Combination]) -> int:
    """How many combinations :func:`combinations` gives."""
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
    """The combinations of a design, in order; those of the design ``list`` are `listed`."""
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
    # SciPy takes half a second to load, which no other design is to wait for.
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
    # Every integer has the same share, those at the ends too.
    wide = Range(start=values.start - 0.5, stop=values.stop + 0.5, logarithmic=values.logarithmic)
    return min(max(round(wide.at(fraction)), round(values.start)), round(values.stop))
