"""Check scenes against their exact solutions, each at several resolutions."""

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import active_children, get_context

import xarray as xr

from harness.errors import HarnessError, in_one_line
from harness.machine import usable_cores
from harness.run.resources import UPDATE_RATE
from harness.study.scene_part import loaded_scenes
from mpm_warp.results import labelled
from mpm_warp.scenes import CatalogueScene, Verification, scene_class


@dataclass(frozen=True, kw_only=True)
class Check:
    """A check: a scene with one set of parameters, its resolutions, and bounds of the error."""

    scene: str
    verification: Verification

    @property
    def label(self) -> str:
        """The scene and those parameters that differ from the defaults."""
        settings = self.verification.settings
        return " ".join([self.scene, *(f"{key}={value}" for key, value in settings.items())])

    @property
    def runs(self) -> list[CatalogueScene]:
        """The scene at each resolution."""
        verification, scene = self.verification, scene_class(self.scene)
        return [
            scene(**verification.settings, **{verification.resolution: resolution})
            for resolution in verification.resolutions
        ]

    @property
    def predicted_time(self) -> float:
        """Approximate time of all its runs on one thread [s]; runs of unknown size count as 0."""
        sizes = [scene.run_size() for scene in self.runs]
        return sum(size.particle_updates / UPDATE_RATE for size in sizes if size is not None)


@dataclass(frozen=True, kw_only=True)
class Verified:
    """The results of a check by resolution: a dataset, or None and a message if the run failed."""

    check: Check
    results: tuple[xr.Dataset | None, ...]
    messages: tuple[str, ...]

    def values(self, name: str) -> tuple[float, ...]:
        """A scalar at each resolution; NaN where the run failed."""
        return tuple(math.nan if d is None else float(d[name]) for d in self.results)

    @property
    def order(self) -> float:
        """Observed order between the two finest resolutions; NaN if there is none."""
        if len(self.results) < 2:
            return math.nan
        coarse, fine = self.values("error")[-2:]
        ratio = self.check.verification.resolutions[-1] / self.check.verification.resolutions[-2]
        return math.log(coarse / fine) / math.log(ratio) if coarse > 0 and fine > 0 else math.nan

    @property
    def shortfalls(self) -> tuple[str, ...]:
        """A text for each bound that is missed; empty if the check has passed."""
        verification = self.check.verification
        failed = [
            f"{name} {value:.3g} > {bound:g}"
            for name, bound in verification.bounds.items()
            if not (value := self.values(name)[-1]) <= bound
        ]
        least = verification.least_order
        if least is not None and not self.order >= least:
            failed.append(f"order {self.order:.2f} < {least:g}")
        return tuple(failed + [message for message in self.messages if message])


def checks_of(names: Sequence[str] = (), *, extreme: bool = False) -> tuple[Check, ...]:
    """The checks, or the extreme ones, of the named scenes; each named scene must have one.

    Without names the checks are those of all scenes with an exact solution.
    """
    scenes = {name: scene_class(name) for name in names} or loaded_scenes()
    checks = tuple(
        Check(scene=name, verification=verification)
        for name, scene in scenes.items()
        for verification in scene.verifications
        if verification.extreme == extreme
    )
    checked = {check.scene for check in checks}
    for name in names:
        if not scenes[name].verifications:
            raise HarnessError(f"{name}: the scene has no exact solution")
        if name not in checked:
            other = "no extreme check" if extreme else "extreme checks alone: add --extreme"
            raise HarnessError(f"{name}: the scene has {other}")
    return checks


QUICK_TIME = 20.0
"""Longest predicted time of a quick check [s]."""


def quick(checks: Sequence[Check]) -> tuple[Check, ...]:
    """The cheapest check of each scene, without those that take longer than `QUICK_TIME`."""
    by_scene: dict[str, Check] = {}
    for check in sorted(checks, key=lambda it: it.predicted_time):
        by_scene.setdefault(check.scene, check)
    chosen = tuple(
        candidate
        for candidate in checks
        if candidate is by_scene[candidate.scene] and candidate.predicted_time < QUICK_TIME
    )
    if not chosen:
        names = ", ".join(dict.fromkeys(check.scene for check in checks))
        raise HarnessError(
            f"--quick: no check of {names} takes less than {QUICK_TIME:g} s; leave it out"
        )
    return chosen


def verified_in_turn(checks: Sequence[Check]) -> Iterator[Verified]:
    """Run checks in parallel on the usable cores; yield the results in the given order."""
    workers = min(usable_cores(), len(checks))
    if workers < 2 or sum(candidate.predicted_time for candidate in checks) < QUICK_TIME:
        yield from map(verify, checks)
        return
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        try:
            yield from pool.map(verify, checks)
        except KeyboardInterrupt:
            for worker in active_children():  # the pool would wait for checks that are running
                worker.terminate()
            raise
        finally:
            pool.shutdown(cancel_futures=True)


def verify(check: Check) -> Verified:
    """Run a check; a run that raises an exception has a message instead of a result."""
    outcomes: list[tuple[xr.Dataset | None, str]] = []
    for scene in check.runs:
        try:
            outcomes.append((scene.run(), ""))
        except Exception as error:
            outcomes.append((None, in_one_line(error)))
    results, messages = zip(*outcomes, strict=True)
    return Verified(check=check, results=results, messages=messages)


LONGEST_LABEL = 44
ROW = "{:44}  {:20}  {:10}  {:8}  {:6}  {:10}  {}"
HEADING = ROW.format("scene", "resolution", "error", "bound", "order", "run time", "").rstrip()


def table_rows(verified: Verified) -> str:
    """Lines of the table, one for each resolution; the last one has the verdict."""
    verification, label = verified.check.verification, verified.check.label
    errors, run_times = verified.values("error"), verified.values("run_time")
    rows = [
        ["", f"{verification.resolution} {resolution}", f"{error:.3g}", "", "", f"{time:.3g} s", ""]
        for resolution, error, time in zip(verification.resolutions, errors, run_times, strict=True)
    ]
    *_, last = rows
    last[3] = f"{verification.bounds['error']:g}"
    last[4] = "" if verification.least_order is None else f"{verified.order:.2f}"
    verdict = "; ".join(verified.shortfalls)
    last[6] = f"FALLS SHORT: {verdict}" if verdict else "pass"
    rows += [
        ["", name, f"{verified.values(name)[-1]:.3g}", f"{bound:g}", "", "", ""]
        for name, bound in verification.bounds.items()
        if name != "error"
    ]
    if has_room := len(label) <= LONGEST_LABEL:
        rows[0][0] = label
    lines = [ROW.format(*row).rstrip() for row in rows]
    return "\n".join(lines if has_room else [label, *lines])


def as_dataset(all_verified: Sequence[Verified]) -> xr.Dataset:
    """Errors, run times and observed orders over `check` and `rank`, the order of resolutions."""
    each = []
    for verified in all_verified:
        resolutions = verified.check.verification.resolutions
        over_ranks = labelled(
            dims=("rank",),
            error=(verified.values("error"), "1", "error against the exact solution"),
            run_time=(verified.values("run_time"), "s", "wall-clock time of the run"),
            resolution=(resolutions, "1", "resolution, in the scene's own parameter"),
        )
        passed = int(not verified.shortfalls)
        alone = labelled(
            order=(verified.order, "1", "observed order between the two finest resolutions"),
            passed=(passed, "1", "1 where every bound is reached"),
        )
        each.append(xr.Dataset(over_ranks | alone, {"rank": range(len(resolutions))}))
    together = xr.concat(each, dim="check", join="outer", combine_attrs="override")
    return together.assign_coords(check=[verified.check.label for verified in all_verified])
