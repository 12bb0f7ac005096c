"""Scenes against their exact solutions: every scene that has one, at its resolutions."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import xarray as xr

from harness.errors import HarnessError, in_one_line
from mpm_warp.parameters import Value
from mpm_warp.scenes import Verification, scene_class, scene_names


@dataclass(frozen=True, kw_only=True)
class Check:
    """A scene with one set of parameters, to be run at all its resolutions.

    Attributes:
        scene: name of the scene.
        verification: resolutions and bounds.
    """

    scene: str
    verification: Verification

    @property
    def label(self) -> str:
        """The scene and the parameters that differ from their defaults."""
        settings = self.verification.settings
        return " ".join([self.scene, *(f"{key}={value}" for key, value in settings.items())])


@dataclass(frozen=True, kw_only=True)
class Verified:
    """The results of a check.

    Attributes:
        check: what was run.
        results: datasets of the scene, one for each resolution; None where the run failed.
        messages: why a run failed, "" where it did not.
    """

    check: Check
    results: tuple[xr.Dataset | None, ...]
    messages: tuple[str, ...]

    def values(self, name: str) -> tuple[float, ...]:
        """A scalar at each resolution; not a number where the run failed."""
        return tuple(math.nan if d is None else float(d[name]) for d in self.results)

    @property
    def order(self) -> float:
        """Observed order between the two finest resolutions; not a number where there is none."""
        if len(self.results) < 2:
            return math.nan
        coarse, fine = self.values("error")[-2:]
        ratio = self.check.verification.resolutions[-1] / self.check.verification.resolutions[-2]
        return math.log(coarse / fine) / math.log(ratio) if coarse > 0 and fine > 0 else math.nan

    @property
    def shortfalls(self) -> tuple[str, ...]:
        """What is not reached, a phrase each; none where the check is passed."""
        verification = self.check.verification
        reached = {name: self.values(name)[-1] for name in verification.bounds}
        failed = [
            f"{name} {value:.3g} > {verification.bounds[name]:g}"
            for name, value in reached.items()
            if not value <= verification.bounds[name]
        ]
        least = verification.least_order
        if least is not None and not self.order >= least:
            failed.append(f"order {self.order:.2f} < {least:g}")
        return tuple(failed + [message for message in self.messages if message])


def checks_of(names: Sequence[str] = (), *, extreme: bool = False) -> tuple[Check, ...]:
    """The checks of the scenes called `names`, or of all that have an exact solution.

    Args:
        names: scenes, all by default.
        extreme: whether the extreme checks are wanted, else all others.

    Raises:
        HarnessError: a scene that is named has none of these checks.
        UnknownSceneError: there is no scene of that name.
    """
    checks = tuple(
        Check(scene=name, verification=verification)
        for name in names or scene_names()
        for verification in scene_class(name).verifications
        if verification.extreme == extreme
    )
    checked = {check.scene for check in checks}
    for name in names:
        if not scene_class(name).verifications:
            raise HarnessError(f"{name}: the scene has no exact solution")
        if name not in checked:
            other = "no extreme check" if extreme else "extreme checks alone: add --extreme"
            raise HarnessError(f"{name}: the scene has {other}")
    return checks


def verify(check: Check) -> Verified:
    """Run a check; the results of a run that ends with an exception are not a number.

    Of several resolutions the coarsest is run once more before the others, so that no run time
    includes the compilation of kernels.
    """
    scene = scene_class(check.scene)
    verification = check.verification

    def parameters(resolution: int) -> Mapping[str, Value]:
        return {**verification.settings, verification.resolution: resolution}

    runs: list[Callable[[], xr.Dataset]] = [
        scene(**parameters(resolution)).run for resolution in verification.resolutions
    ]
    if len(runs) > 1:
        _outcome(runs[0])
    outcomes = [_outcome(run) for run in runs]
    return Verified(
        check=check,
        results=tuple(result for result, _ in outcomes),
        messages=tuple(message for _, message in outcomes),
    )


def _outcome(run: Callable[[], xr.Dataset]) -> tuple[xr.Dataset | None, str]:
    try:
        return run(), ""
    except Exception as error:
        return None, in_one_line(error)


HEADING = ("scene", "resolution", "error", "bound", "order", "run time", "")
WIDTHS = (44, 20, 10, 8, 6, 10, 0)


def table_rows(verified: Verified) -> str:
    """Lines of the table: one for each resolution, the verdict on the last."""
    verification = verified.check.verification
    errors, run_times = verified.values("error"), verified.values("run_time")
    label = verified.check.label
    lines = [label] if len(label) > WIDTHS[0] else []
    for index, resolution in enumerate(verification.resolutions):
        last = index == len(errors) - 1
        order = f"{verified.order:.2f}" if last and verification.least_order is not None else ""
        bound = f"{verification.bounds['error']:g}" if last else ""
        verdict = "; ".join(verified.shortfalls)
        verdict = f"FALLS SHORT: {verdict}" if verdict else "pass"
        lines.append(
            _line(
                label if not lines else "",
                f"{verification.resolution} {resolution}",
                f"{errors[index]:.3g}",
                bound,
                order,
                f"{run_times[index]:.3g} s",
                verdict if last else "",
            )
        )
    lines += [
        _line("", name, f"{verified.values(name)[-1]:.3g}", f"{bound:g}", "", "", "")
        for name, bound in verification.bounds.items()
        if name != "error"
    ]
    return "\n".join(lines)


def heading() -> str:
    """The first line of the table."""
    return _line(*HEADING)


def _line(*texts: str) -> str:
    cells = (text.ljust(width) for text, width in zip(texts, WIDTHS, strict=True))
    return "  ".join(cells).rstrip()


def as_dataset(all_verified: Sequence[Verified]) -> xr.Dataset:
    """Errors, run times and observed orders, over checks and the ranks of their resolutions."""
    each = [_as_dataset(verified) for verified in all_verified]
    together = xr.concat(each, dim="check", join="outer", combine_attrs="override")
    return together.assign_coords(check=[verified.check.label for verified in all_verified])


def _as_dataset(verified: Verified) -> xr.Dataset:
    over_ranks = {
        "error": (verified.values("error"), "1", "error against the exact solution"),
        "run_time": (verified.values("run_time"), "s", "wall-clock time of the run"),
        "resolution": (
            verified.check.verification.resolutions,
            "1",
            "resolution, in the scene's own parameter",
        ),
    }
    order = {"units": "1", "long_name": "observed order between the two finest resolutions"}
    passed = {"units": "1", "long_name": "1 where every bound is reached"}
    return xr.Dataset(
        {
            name: ("rank", list(values), {"units": unit, "long_name": meaning})
            for name, (values, unit, meaning) in over_ranks.items()
        },
        coords={"rank": range(len(verified.results))},
    ).assign(order=((), verified.order, order), passed=((), int(not verified.shortfalls), passed))
