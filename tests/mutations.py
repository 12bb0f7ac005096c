"""Deliberate errors in the simulator, and the tests that turn red by them.

``python tests/mutations.py`` applies each error to a copy of the tree, runs the tests of the
simulator until one fails, and writes the table `tests/mutations.md`. It exits with 1 where an error
goes unnoticed. An error whose text is no longer in its file is one to be rewritten.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
TABLE = ROOT / "tests" / "mutations.md"
KERNELS = "mpm_warp/kernels"


@dataclass(frozen=True)
class Mutation:
    """One deliberate error: in a file, a text that is replaced once."""

    meaning: str
    file: str
    right: str
    wrong: str


MUTATIONS = (
    Mutation(
        "momentum given to the wrong node",
        f"{KERNELS}/particles_to_grid.py",
        "upper, share((one - xi) * eta * m, v)",
        "upper, share(xi * eta * m, v)",
    ),
    Mutation(
        "velocity sharpened by all that smoothing takes at the start",
        "mpm_warp/planning.py",
        "(1.0 - plan.scene.particles_per_side**-2.0) / 24.0",
        "(1.0 + 0.5 * plan.scene.particles_per_side**-2.0) / 24.0",
    ),
    Mutation(
        "momentum of the lumped mass matrix",
        f"{KERNELS}/consistent_mass.py",
        "return m * vec4(",
        "return real(0.0) * m * vec4(",
    ),
    Mutation(
        "stress of a cell not weighted by mass",
        f"{KERNELS}/particles_to_grid.py",
        "wp.atomic_add(cell_stress_sum, c, m * stress[p])",
        "wp.atomic_add(cell_stress_sum, c, stress[p])",
    ),
    Mutation(
        "hoop stress left out of the force",
        f"{KERNELS}/grid_update.py",
        "stress[0] * G[0] + stress[2] * G[1] + stress[3] * G[2]",
        "stress[0] * G[0] + stress[2] * G[1]",
    ),
    Mutation(
        "sign of the shear stress in the force",
        f"{KERNELS}/grid_update.py",
        "stress[2] * G[0] + stress[1] * G[1],",
        "stress[1] * G[1] - stress[2] * G[0],",
    ),
    Mutation(
        "hoop strain left out",
        f"{KERNELS}/grid_update.py",
        "v[1] * G[0], v[1] * G[1], v[0] * G[2])",
        "v[1] * G[0], v[1] * G[1], real(0.0) * G[2])",
    ),
    Mutation(
        "spin of the wrong sign",
        f"{KERNELS}/grid_update.py",
        "t = quarter * time_step * (L[1] - L[2])",
        "t = quarter * time_step * (L[2] - L[1])",
    ),
    Mutation(
        "half the shear strain",
        f"{KERNELS}/grid_update.py",
        "shear_modulus * time_step * (L[1] + L[2])",
        "real(0.5) * shear_modulus * time_step * (L[1] + L[2])",
    ),
    Mutation(
        "sign of the bulk viscosity",
        f"{KERNELS}/grid_update.py",
        "q = viscosity[c] * dilation_rate[c]",
        "q = -viscosity[c] * dilation_rate[c]",
    ),
    Mutation(
        "particles moved by half their velocity",
        f"{KERNELS}/grid_to_particles.py",
        "x += time_step * v\n",
        "x += real(0.5) * time_step * v\n",
    ),
    Mutation(
        "flow not made even within cells",
        f"{KERNELS}/grid_to_particles.py",
        "x += vec2(across + upright * step[9], upright * step[10])",
        "x += real(0.0) * vec2(across + upright * step[9], upright * step[10])",
    ),
    Mutation(
        "even flow without the hoop's part",
        f"{KERNELS}/even_flow.py",
        "- weight[3] * left\n",
        "\n",
    ),
    Mutation(
        "rotation of the stress turned round",
        f"{KERNELS}/grid_to_particles.py",
        "cc * rr + ss * zz + two * cs * rz + step[0]",
        "cc * rr + ss * zz - two * cs * rz + step[0]",
    ),
    Mutation(
        "strength of Tresca's corner",
        f"{KERNELS}/yielding.py",
        "new_lowest = mean - real(4.0) * third",
        "new_lowest = mean - real(2.0) * third",
    ),
    Mutation(
        "half of Tresca's strength",
        f"{KERNELS}/yielding.py",
        "new_highest = mean_of_extremes + strength",
        "new_highest = mean_of_extremes",
    ),
    Mutation(
        "adhesion without the time step",
        f"{KERNELS}/contact.py",
        "friction, adhesion[k] * time_step, in_situ)",
        "friction, adhesion[k], in_situ)",
    ),
    Mutation(
        "friction of the excess stress alone",
        f"{KERNELS}/contact.py",
        "pressing = m * wp.dot(d, n) + in_situ",
        "pressing = m * wp.dot(d, n)",
    ),
    Mutation(
        "bodies that pull on each other",
        f"{KERNELS}/contact.py",
        "wp.max(m * normal_speed, -pressure)",
        "m * normal_speed",
    ),
    Mutation(
        "contact area as half of each edge, without r",
        "mpm_warp/penetrometer.py",
        "to_lower = length * (radius[:-1] / 3.0 + radius[1:] / 6.0)",
        "to_lower = length * (radius[:-1] / 2.0)",
    ),
    Mutation(
        "particle volumes without r",
        "mpm_warp/grids.py",
        "volumes: Floats = weight * width * np.diff(self.rows)[row]",
        "volumes: Floats = (0 * weight + 1) * width * np.diff(self.rows)[row]",
    ),
    Mutation(
        "far field that pushes outward",
        f"{KERNELS}/boundaries.py",
        "- rate * spring[k] * displacement[k]",
        "+ rate * spring[k] * displacement[k]",
    ),
    Mutation(
        "soil that enters at the wrong height",
        "mpm_warp/travel.py",
        "lift=now - next_layer",
        "lift=0.0",
    ),
    Mutation(
        "wall whose cells do not follow",
        f"{KERNELS}/moving_wall.py",
        "volume[c] = (a + half * w) * w * h",
        "volume[c] = a * w * h",
    ),
    Mutation(
        "sectors refitted without the turn of the rays",
        f"{KERNELS}/moving_wall.py",
        "P * t[2] - Q * t[3]",
        "P * t[2]",
    ),
    Mutation(
        "polar angle from the wrong axis",
        f"{KERNELS}/location.py",
        "wp.atan2(x[0], x[1])",
        "wp.atan2(x[1], x[0])",
    ),
    Mutation(
        "surface of the ground not seen by its cells",
        f"{KERNELS}/grid_update.py",
        "mean *= wp.min(m / full_mass[c], one)",
        "mean *= one",
    ),
    Mutation(
        "hoop stress of a body turned round",
        f"{KERNELS}/body_to_grid.py",
        "force -= V * vec2(sigma[3]",
        "force += V * vec2(sigma[3]",
    ),
    Mutation(
        "surface of a ring without its 1/r",
        f"{KERNELS}/body_to_grid.py",
        "G += vec2(N / x[0], real(0.0))",
        "G += vec2(real(0.0), real(0.0))",
    ),
    Mutation(
        "twice the adhesion between bodies",
        f"{KERNELS}/body_contact.py",
        "adhesion * area * time_step",
        "real(2.0) * adhesion * area * time_step",
    ),
    Mutation(
        "impulse that both bodies take the same way",
        f"{KERNELS}/body_contact.py",
        "velocity[base, k] + inverse_mass",
        "velocity[base, k] - inverse_mass",
    ),
    Mutation(
        "contact a cell too early",
        f"{KERNELS}/body_contact.py",
        "if gap > closed or mobility <= zero",
        "if mobility <= zero",
    ),
    Mutation(
        "pressure shared to twice its sum",
        f"{KERNELS}/body_contact.py",
        "pressure[k] = pressing[k][0] / area",
        "pressure[k] = real(2.0) * pressing[k][0] / area",
    ),
    Mutation(
        "affine velocity too small",
        f"{KERNELS}/grid_to_body.py",
        "(four / (h * h)) * B",
        "(real(3.0) / (h * h)) * B",
    ),
    Mutation(
        "a share of each launch left out",
        "mpm_warp/sharing.py",
        "(thread + 1) * share_count // threads)",
        "(thread + 1) * share_count // threads - thread)",
    ),
    Mutation(
        "what one thread is to do done by all",
        "mpm_warp/sharing.py",
        "[launch.share(0, 1)] if thread == 0 else []",
        "[launch.share(0, 1)]",
    ),
    Mutation(
        "pieces done by all who try to claim them",
        f"{KERNELS}/claim.py",
        "before != now",
        "true",
    ),
    Mutation(
        "one step too many",
        f"{KERNELS}/next_step.py",
        "int(step < loop[wp.static(END)])",
        "int(step <= loop[wp.static(END)])",
    ),
    Mutation(
        "steps audited that are not to be",
        f"{KERNELS}/next_step.py",
        "int(step % wp.static(AUDIT_INTERVAL) == 0)",
        "int(step % wp.static(AUDIT_INTERVAL) == 1)",
    ),
    Mutation(
        "threads that do not wait for each other",
        f"{KERNELS}/rendezvous.py",
        "arrivals.shape[0]; ++other",
        "0; ++other",
    ),
    Mutation(
        "sums of one share alone",
        f"{KERNELS}/grid_update.py",
        "sums += part",
        "sums = part",
    ),
    Mutation(
        "approach that does not slow down",
        f"{KERNELS}/window.py",
        "final_speed + left * (speed - final_speed)",
        "speed + left * (speed - final_speed)",
    ),
    Mutation(
        "operations counted as often as they are written",
        "mpm_warp/counting_numbers.py",
        "if key not in self._known:",
        "if key:",
    ),
    Mutation(
        "divisions counted as other operations",
        "mpm_warp/counting_numbers.py",
        'is_division = name in {"/", "root"}',
        "is_division = False",
    ),
    Mutation(
        "a comparison turned round where operations are counted",
        "mpm_warp/counting_numbers.py",
        "self.value >= other.value",
        "self.value < other.value",
    ),
    Mutation(
        "bytes that threads share counted for each",
        "mpm_warp/counting.py",
        "min(self._size, count * self._element_size / share)",
        "count * self._element_size / share",
    ),
    Mutation(
        "the window taken for slower than it is on its way",
        "mpm_warp/window.py",
        "min(1.0, max(0.0, left)) * (self",
        "min(1.0, max(0.0, left)) ** 2 * (self",
    ),
    Mutation(
        "cases of a batch with the numbers of the first",
        "mpm_warp/stack.py",
        "it.arguments[position] for it in alike",
        "launch.arguments[position] for it in alike",
    ),
    Mutation(
        "runs of a batch with the soil of the first",
        "mpm_warp/stack.py",
        "wp.copy(whole[number], own[number])",
        "wp.copy(whole[number], own[0])",
    ),
    Mutation(
        "runs at different steps taken for alike",
        "mpm_warp/batch.py",
        "groups[run.likeness, run.left.start]",
        "groups[run.likeness]",
    ),
    Mutation(
        "a return to the yield surface that adds pressure",
        f"{KERNELS}/yielding.py",
        "new_highest = mean_of_extremes + strength",
        "new_highest = mean_of_extremes + real(1.001) * strength",
    ),
    Mutation(
        "emptied cells not looked for",
        "mpm_warp/watch.py",
        "check_blocks(self._blocks(mass), self._first_blocks)",
        "pass",
    ),
    Mutation(
        "lost contact not looked for",
        "mpm_warp/watch.py",
        "check_contact(contact, velocity, speed=before.speed)",
        "pass",
    ),
    Mutation(
        "mean stress noted after the step instead of before it",
        "mpm_warp/simulation.py",
        "            if is_watched:\n                self._prepare_look()\n",
        "",
    ),
    Mutation(
        "no curves of a run that diverged",
        "mpm_warp/history.py",
        "error.history = curves()",
        "pass",
    ),
    Mutation(
        "time that forgets the steps before a change",
        "mpm_warp/simulation.py",
        "self._changed_step, self._changed_time = self.step_count, self.time",
        "self._changed_step, self._changed_time = self.step_count, 0.0",
    ),
    Mutation(
        "critical time step of the body at rest",
        "mpm_warp/bodies/planning.py",
        "body.critical_time_step(scene.grid.cell_size, thinning)",
        "body.critical_time_step(scene.grid.cell_size)",
    ),
    Mutation(
        "gain by threads upside down",
        "mpm_warp/speed.py",
        "(alone.seconds / alone.steps) / (taken.seconds / taken.steps)",
        "(taken.seconds / taken.steps) / (alone.seconds / alone.steps)",
    ),
)


def red_test(mutation: Mutation) -> str | None:
    """The first test that fails with the error in place; None where none does."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in ("mpm_warp", "tests"):
            shutil.copytree(ROOT / name, copy / name)
        shutil.copy(ROOT / "pyproject.toml", copy)
        file = copy / mutation.file
        text = file.read_text()
        if mutation.right not in text:
            raise SystemExit(f"{mutation.meaning}: {mutation.right!r} is not in {mutation.file}")
        file.write_text(text.replace(mutation.right, mutation.wrong, 1))
        run = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-x", "--tb=no", "tests/mpm_warp"],
            cwd=copy,
            env=os.environ | {"PYTHONPATH": str(copy)},
            capture_output=True,
            text=True,
            check=False,
        )
    failed = [line for line in run.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0].split("::")[-1].split(" - ")[0] if failed else None


def main() -> int:
    """Try every error; returns the exit code."""
    lines = [
        "# Deliberate errors and the first test that each turns red",
        "",
        "Written by `python tests/mutations.py`.",
        "",
        "| error | file | test |",
        "|---|---|---|",
    ]
    unnoticed = 0
    for mutation in MUTATIONS:
        test = red_test(mutation)
        unnoticed += test is None
        lines.append(f"| {mutation.meaning} | `{mutation.file}` | {test or '**none**'} |")
        print(lines[-1], flush=True)
    TABLE.write_text("\n".join(lines) + "\n")
    return 1 if unnoticed else 0


if __name__ == "__main__":
    sys.exit(main())
