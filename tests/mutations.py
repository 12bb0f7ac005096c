"""Deliberate errors, and for each the test that is to notice it.

``python tests/mutations.py`` puts each error into a copy of the tree, runs its test alone, and
writes the table `tests/mutations.md`. ``python tests/mutations.py WORD ...`` tries only those whose
meaning has one of the words in it, and writes nothing.

An error is noticed where the test fails: not where it passes, cannot be collected or set up, or
takes too long. Without an error all of these tests have to pass. The exit code is 1 where an error
goes unnoticed. One whose text is not in its file, or more than once, is to be rewritten.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
TABLE = ROOT / "tests" / "mutations.md"
COPIED = ("harness", "mpm_warp", "studies", "tests", "pyproject.toml")
KERNELS = "mpm_warp/kernels"
OF_MPM = "tests/mpm_warp"
TIME_LIMIT = 300.0
"""Time that a test may take with an error in place [s]: many times what any takes without."""
PASSED, FAILED = "passed", "failed"


@dataclass(frozen=True)
class Mutation:
    """One deliberate error: in a file, a text that is replaced; and the test that notices it.

    Attributes:
        meaning: what is wrong.
        file: that it is in.
        right: text of the file, which is there once.
        wrong: what stands there instead.
        test_file: with the test.
        test: its name, for one of its cases with the parameters.
    """

    meaning: str
    file: str
    right: str
    wrong: str
    test_file: str
    test: str

    @property
    def node(self) -> str:
        """The test by pytest's name for it."""
        return f"{self.test_file}::{self.test}"

    def apply(self, tree: Path) -> None:
        """Put the error into a tree."""
        file = tree / self.file
        text = file.read_text()
        if text.count(self.right) != 1:
            raise SystemExit(f"{self.meaning}: {self.right!r} is not once in {self.file}")
        file.write_text(text.replace(self.right, self.wrong))


MUTATIONS = (
    Mutation(
        "momentum given to the wrong node",
        f"{KERNELS}/particles_to_grid.py",
        "upper, share((one - xi) * eta * m, v)",
        "upper, share(xi * eta * m, v)",
        f"{OF_MPM}/test_simulation.py",
        "test_a_linear_velocity_arrives_at_the_nodes_amid_a_regular_lattice",
    ),
    Mutation(
        "velocity sharpened by all that smoothing takes at the start",
        "mpm_warp/planning.py",
        "(1.0 - plan.scene.particles_per_side**-2.0) / 24.0",
        "(1.0 + 0.5 * plan.scene.particles_per_side**-2.0) / 24.0",
        f"{OF_MPM}/test_transfer.py",
        "test_sharpening_gives_back_its_share_of_what_alternates_upward",
    ),
    Mutation(
        "momentum of the lumped mass matrix",
        f"{KERNELS}/consistent_mass.py",
        "return m * vec4(",
        "return real(0.0) * m * vec4(",
        f"{OF_MPM}/verification/test_exact_solutions.py",
        "test_standing_wave",
    ),
    Mutation(
        "stress of a cell not weighted by mass",
        f"{KERNELS}/particles_to_grid.py",
        "wp.atomic_add(cell_stress_sum, c, m * stress[p])",
        "wp.atomic_add(cell_stress_sum, c, stress[p])",
        f"{OF_MPM}/test_simulation.py",
        "test_a_cell_at_the_surface_of_the_ground_bears_stress_as_far_as_it_is_filled",
    ),
    Mutation(
        "hoop stress left out of the force",
        f"{KERNELS}/grid_update.py",
        "stress[0] * G[0] + stress[2] * G[1] + stress[3] * G[2]",
        "stress[0] * G[0] + stress[2] * G[1]",
        f"{OF_MPM}/verification/test_exact_solutions.py",
        "test_thick_cylinder_is_of_second_order[0.3]",
    ),
    Mutation(
        "sign of the shear stress in the force",
        f"{KERNELS}/grid_update.py",
        "stress[2] * G[0] + stress[1] * G[1],",
        "stress[1] * G[1] - stress[2] * G[0],",
        f"{OF_MPM}/verification/test_exact_solutions.py",
        "test_cone_at_the_surface[0.0]",
    ),
    Mutation(
        "hoop strain left out",
        f"{KERNELS}/grid_update.py",
        "v[1] * G[0], v[1] * G[1], v[0] * G[2])",
        "v[1] * G[0], v[1] * G[1], real(0.0) * G[2])",
        f"{OF_MPM}/test_simulation.py",
        "test_a_step_from_rest_has_hookes_stress",
    ),
    Mutation(
        "spin of the wrong sign",
        f"{KERNELS}/grid_update.py",
        "t = quarter * time_step * (L[1] - L[2])",
        "t = quarter * time_step * (L[2] - L[1])",
        f"{OF_MPM}/test_simulation.py",
        "test_spin_turns_the_stress_by_its_angle",
    ),
    Mutation(
        "half the shear strain",
        f"{KERNELS}/grid_update.py",
        "shear_modulus * time_step * (L[1] + L[2])",
        "real(0.5) * shear_modulus * time_step * (L[1] + L[2])",
        f"{OF_MPM}/test_simulation.py",
        "test_a_step_from_rest_has_hookes_stress",
    ),
    Mutation(
        "sign of the bulk viscosity",
        f"{KERNELS}/grid_update.py",
        "q = viscosity[c] * dilation_rate[c]",
        "q = -viscosity[c] * dilation_rate[c]",
        f"{OF_MPM}/verification/test_extreme_scenes.py",
        "test_shock[0.5-StruckColumn]",
    ),
    Mutation(
        "particles moved by half their velocity",
        f"{KERNELS}/grid_to_particles.py",
        "x += time_step * v\n",
        "x += real(0.5) * time_step * v\n",
        f"{OF_MPM}/test_simulation.py",
        "test_a_rigid_motion_along_the_axis_leaves_no_stress_and_keeps_momentum",
    ),
    Mutation(
        "flow not made even within cells",
        f"{KERNELS}/grid_to_particles.py",
        "x += vec2(across + upright * step[9], upright * step[10])",
        "x += real(0.0) * vec2(across + upright * step[9], upright * step[10])",
        f"{OF_MPM}/test_even_flow.py",
        "test_particles_move_with_it",
    ),
    Mutation(
        "even flow without the hoop's part",
        f"{KERNELS}/even_flow.py",
        "- weight[3] * left\n",
        "\n",
        f"{OF_MPM}/test_even_flow.py",
        "test_particles_move_with_it",
    ),
    Mutation(
        "rotation of the stress turned round",
        f"{KERNELS}/grid_to_particles.py",
        "cc * rr + ss * zz + two * cs * rz + step[0]",
        "cc * rr + ss * zz - two * cs * rz + step[0]",
        f"{OF_MPM}/test_simulation.py",
        "test_spin_turns_the_stress_by_its_angle",
    ),
    Mutation(
        "strength of Tresca's corner",
        f"{KERNELS}/yielding.py",
        "new_lowest = mean - real(4.0) * third",
        "new_lowest = mean - real(2.0) * third",
        f"{OF_MPM}/test_yielding.py",
        "test_tresca_returns_to_the_nearest_point",
    ),
    Mutation(
        "half of Tresca's strength",
        f"{KERNELS}/yielding.py",
        "new_highest = mean_of_extremes + strength",
        "new_highest = mean_of_extremes",
        f"{OF_MPM}/test_yielding.py",
        "test_tresca_returns_to_the_nearest_point",
    ),
    Mutation(
        "adhesion without the time step",
        f"{KERNELS}/contact.py",
        "friction, adhesion[k] * time_step, in_situ)",
        "friction, adhesion[k], in_situ)",
        f"{OF_MPM}/test_cone_penetration.py",
        "test_shear_part_of_every_apex_angle_obeys_statics[30.0]",
    ),
    Mutation(
        "friction of the excess stress alone",
        f"{KERNELS}/contact.py",
        "pressing = m * wp.dot(d, n) + in_situ",
        "pressing = m * wp.dot(d, n)",
        f"{OF_MPM}/test_cone_penetration.py",
        "test_shaft_friction_is_the_adhesion_once_the_shaft_slips",
    ),
    Mutation(
        "bodies that pull on each other",
        f"{KERNELS}/contact.py",
        "wp.max(m * normal_speed, -pressure)",
        "m * normal_speed",
        f"{OF_MPM}/test_contact_law.py",
        "test_bodies_that_part_exchange_nothing_not_even_adhesion",
    ),
    Mutation(
        "contact area of each edge shared evenly, whatever its radii",
        "mpm_warp/penetrometer.py",
        "to_lower = length * (radius[:-1] / 3.0 + radius[1:] / 6.0)",
        "to_lower = length * (radius[:-1] / 4.0 + radius[1:] / 4.0)",
        f"{OF_MPM}/test_penetrometer.py",
        "test_areas_of_face_and_shaft_are_exact",
    ),
    Mutation(
        "particle volumes without r",
        "mpm_warp/grids.py",
        "volumes: Floats = weight * width * np.diff(self.rows)[row]",
        "volumes: Floats = (0 * weight + 1) * width * np.diff(self.rows)[row]",
        f"{OF_MPM}/test_grids.py",
        "test_particles_hold_the_volume_of_their_cells",
    ),
    Mutation(
        "far field that pushes outward",
        f"{KERNELS}/boundaries.py",
        "- rate * spring[k] * displacement[k]",
        "+ rate * spring[k] * displacement[k]",
        f"{OF_MPM}/test_simulation.py",
        "test_the_far_field_pushes_back_like_an_elastic_cavity",
    ),
    Mutation(
        "soil that enters at the wrong height",
        "mpm_warp/travel.py",
        "lift=now - next_layer",
        "lift=0.0",
        f"{OF_MPM}/test_simulation.py",
        "test_undisturbed_soil_in_the_window_stays_exactly_at_rest",
    ),
    Mutation(
        "wall whose cells do not follow",
        f"{KERNELS}/moving_wall.py",
        "volume[c] = (a + half * w) * w * h",
        "volume[c] = a * w * h",
        f"{OF_MPM}/verification/test_cavity.py",
        "test_the_grid_that_followed_the_wall_is_the_grid_around_it",
    ),
    Mutation(
        "sectors refitted without the turn of the rays",
        f"{KERNELS}/moving_wall.py",
        "P * t[2] - Q * t[3]",
        "P * t[2]",
        f"{OF_MPM}/verification/test_exact_solutions.py",
        "test_pressure_of_a_spherical_cavity",
    ),
    Mutation(
        "polar angle from the wrong axis",
        f"{KERNELS}/location.py",
        "wp.atan2(x[0], x[1])",
        "wp.atan2(x[1], x[0])",
        f"{OF_MPM}/test_polar.py",
        "test_device_places_a_particle_where_the_grid_does",
    ),
    Mutation(
        "surface of the ground not seen by its cells",
        f"{KERNELS}/grid_update.py",
        "mean *= wp.min(m / full_mass[c], one)",
        "mean *= one",
        f"{OF_MPM}/test_simulation.py",
        "test_a_cell_at_the_surface_of_the_ground_bears_stress_as_far_as_it_is_filled",
    ),
    Mutation(
        "hoop stress of a body turned round",
        f"{KERNELS}/body_to_grid.py",
        "force -= V * vec2(sigma[3]",
        "force += V * vec2(sigma[3]",
        f"{OF_MPM}/bodies/test_body_contact.py",
        "test_ring_breathes_at_its_frequency",
    ),
    Mutation(
        "surface of a ring without its 1/r",
        f"{KERNELS}/body_to_grid.py",
        "G += vec2(N / x[0], real(0.0))",
        "G += vec2(real(0.0), real(0.0))",
        f"{OF_MPM}/verification/test_sliding_block.py",
        "test_adhesion_does_not_depend_on_pressure_shape_or_mass[1.0-2.0-500.0]",
    ),
    Mutation(
        "twice the adhesion between bodies",
        f"{KERNELS}/body_contact.py",
        "adhesion * area * time_step",
        "real(2.0) * adhesion * area * time_step",
        f"{OF_MPM}/bodies/test_body_contact.py",
        "test_impulse_of_a_step_is_the_law_summed_over_nodes",
    ),
    Mutation(
        "impulse that both bodies take the same way",
        f"{KERNELS}/body_contact.py",
        "velocity[base, k] + inverse_mass",
        "velocity[base, k] - inverse_mass",
        f"{OF_MPM}/bodies/test_body_contact.py",
        "test_impulses_on_two_free_bodies_sum_to_zero[0.0]",
    ),
    Mutation(
        "contact a cell too early",
        f"{KERNELS}/body_contact.py",
        "if gap > closed or mobility <= zero",
        "if mobility <= zero",
        f"{OF_MPM}/bodies/test_body_contact.py",
        "test_bodies_feel_each_other_when_they_touch_and_not_a_cell_before",
    ),
    Mutation(
        "pressure shared to twice its sum",
        f"{KERNELS}/body_contact.py",
        "pressure[k] = pressing[k][0] / area",
        "pressure[k] = real(2.0) * pressing[k][0] / area",
        f"{OF_MPM}/verification/test_sliding_block.py",
        "test_acceleration_along_the_grid[0.0-0.0-0.3]",
    ),
    Mutation(
        "affine velocity too small",
        f"{KERNELS}/grid_to_body.py",
        "(four / (h * h)) * B",
        "(real(3.0) / (h * h)) * B",
        f"{OF_MPM}/verification/test_extreme_scenes.py",
        "test_free_flight_keeps_momentum_spin_and_shape",
    ),
    Mutation(
        "a share of each launch left out",
        "mpm_warp/sharing.py",
        "(thread + 1) * share_count // threads)",
        "(thread + 1) * share_count // threads - thread)",
        f"{OF_MPM}/test_threads.py",
        "test_what_threads_do_of_a_launch_makes_up_the_whole[2]",
    ),
    Mutation(
        "what one thread is to do done by all",
        "mpm_warp/sharing.py",
        "[launch.share(0, 1)] if thread == 0 else []",
        "[launch.share(0, 1)]",
        f"{OF_MPM}/test_threads.py",
        "test_what_threads_do_of_a_launch_makes_up_the_whole[2]",
    ),
    Mutation(
        "pieces done by all who try to claim them",
        f"{KERNELS}/claim.py",
        "before != now",
        "true",
        f"{OF_MPM}/test_threads.py",
        "test_threads_do_not_change_a_bit[2]",
    ),
    Mutation(
        "one step too many",
        f"{KERNELS}/next_step.py",
        "int(step < loop[wp.static(END)])",
        "int(step <= loop[wp.static(END)])",
        f"{OF_MPM}/test_threads.py",
        "test_steps_are_the_same_however_they_are_parted",
    ),
    Mutation(
        "steps audited that are not to be",
        f"{KERNELS}/next_step.py",
        "int(step % wp.static(AUDIT_INTERVAL) == 0)",
        "int(step % wp.static(AUDIT_INTERVAL) == 1)",
        f"{OF_MPM}/test_threads.py",
        "test_steps_are_the_same_one_by_one_as_on_a_gpu",
    ),
    Mutation(
        "threads that do not wait for each other",
        f"{KERNELS}/rendezvous.py",
        "arrivals.shape[0]; ++other",
        "0; ++other",
        f"{OF_MPM}/test_threads.py",
        "test_threads_do_not_change_a_bit[2]",
    ),
    Mutation(
        "sums of one share alone",
        f"{KERNELS}/grid_update.py",
        "sums += part",
        "sums = part",
        f"{OF_MPM}/test_simulation.py",
        "test_momentum_along_the_axis_is_kept_while_waves_run",
    ),
    Mutation(
        "approach that does not slow down",
        f"{KERNELS}/window.py",
        "final_speed + left * (speed - final_speed)",
        "speed + left * (speed - final_speed)",
        f"{OF_MPM}/test_window.py",
        "test_a_run_takes_the_steps_that_its_plan_says",
    ),
    Mutation(
        "operations counted as often as they are written",
        "mpm_warp/counting_numbers.py",
        "if key not in self._known:",
        "if key:",
        f"{OF_MPM}/test_counting.py",
        "test_operations_of_a_known_kernel",
    ),
    Mutation(
        "divisions counted as other operations",
        "mpm_warp/counting_numbers.py",
        'is_division = name in {"/", "root"}',
        "is_division = False",
        f"{OF_MPM}/test_counting.py",
        "test_operations_of_a_known_kernel[0.75-3]",
    ),
    Mutation(
        "a comparison turned round where operations are counted",
        "mpm_warp/counting_numbers.py",
        "self.value >= other.value",
        "self.value < other.value",
        f"{OF_MPM}/test_counting.py",
        "test_what_is_counted_computes_what_the_kernels_do[cone]",
    ),
    Mutation(
        "bytes that threads share counted for each",
        "mpm_warp/counting.py",
        "min(self._size, count * self._element_size / share)",
        "count * self._element_size / share",
        f"{OF_MPM}/test_counting.py",
        "test_operations_of_a_known_kernel",
    ),
    Mutation(
        "the window taken for slower than it is on its way",
        "mpm_warp/window.py",
        "min(1.0, max(0.0, left)) * (self",
        "min(1.0, max(0.0, left)) ** 2 * (self",
        f"{OF_MPM}/test_window.py",
        "test_no_speed_is_above_the_highest_beyond_a_travel",
    ),
    Mutation(
        "cases of a batch with the numbers of the first",
        "mpm_warp/stack.py",
        "it.arguments[position] for it in alike",
        "launch.arguments[position] for it in alike",
        f"{OF_MPM}/test_batch.py",
        "test_a_thread_for_each_item_gives_the_same_bits",
    ),
    Mutation(
        "runs of a batch with the soil of the first",
        "mpm_warp/stack.py",
        "wp.copy(whole[number], own[number])",
        "wp.copy(whole[number], own[0])",
        f"{OF_MPM}/test_batch.py",
        "test_a_thread_for_each_item_gives_the_same_bits",
    ),
    Mutation(
        "runs at different steps taken for alike",
        "mpm_warp/batch.py",
        "groups[run.likeness, run.left.start]",
        "groups[run.likeness]",
        f"{OF_MPM}/test_batch.py",
        "test_runs_that_begin_later_go_on_beside_those_before_them",
    ),
    Mutation(
        "a return to the yield surface that adds pressure",
        f"{KERNELS}/yielding.py",
        "new_highest = mean_of_extremes + strength",
        "new_highest = mean_of_extremes + real(1.001) * strength",
        f"{OF_MPM}/test_yielding.py",
        "test_returns_keep_pressure_directions_and_what_is_inside",
    ),
    Mutation(
        "emptied cells not looked for",
        "mpm_warp/watch.py",
        "check_blocks(self._blocks(mass), self._first_blocks)",
        "pass",
        f"{OF_MPM}/test_health.py",
        "test_cells_that_have_lost_their_soil_are_noticed[cavity_sphere]",
    ),
    Mutation(
        "lost contact not looked for",
        "mpm_warp/watch.py",
        "check_contact(contact, velocity, speed=before.speed)",
        "pass",
        f"{OF_MPM}/test_health.py",
        "test_contact_that_is_lost_is_noticed[circular_footing]",
    ),
    Mutation(
        "mean stress noted after the step instead of before it",
        "mpm_warp/simulation.py",
        "            if is_watched:\n                self._prepare_look()\n",
        "",
        f"{OF_MPM}/test_health.py",
        "test_drift_of_the_mean_stress_is_noticed[float64]",
    ),
    Mutation(
        "no curves of a run that diverged",
        "mpm_warp/history.py",
        "error.history = curves()",
        "pass",
        f"{OF_MPM}/test_kept_curves.py",
        "test_curves_up_to_the_failure_are_those_of_the_whole_run[cavity_cylinder-parameters0-expansion]",
    ),
    Mutation(
        "time that forgets the steps before a change",
        "mpm_warp/simulation.py",
        "self._changed_step, self._changed_time = self.step_count, self.time",
        "self._changed_step, self._changed_time = self.step_count, 0.0",
        f"{OF_MPM}/test_time_step.py",
        "test_time_is_the_sum_of_the_steps",
    ),
    Mutation(
        "critical time step of the body at rest",
        "mpm_warp/bodies/planning.py",
        "body.critical_time_step(scene.grid.cell_size, thinning)",
        "body.critical_time_step(scene.grid.cell_size)",
        f"{OF_MPM}/test_time_step.py",
        "test_a_bar_that_is_drawn_out_takes_shorter_steps_and_no_more_than_it_needs",
    ),
    Mutation(
        "gain by threads upside down",
        "mpm_warp/speed.py",
        "(alone.seconds / alone.steps) / (taken.seconds / taken.steps)",
        "(taken.seconds / taken.steps) / (alone.seconds / alone.steps)",
        f"{OF_MPM}/test_speed.py",
        "test_the_gain_by_threads_is_that_over_one",
    ),
    Mutation(
        "runs of a batch one by one",
        "mpm_warp/batch.py",
        "for first in range(0, len(alike), size):",
        "for first in range(0, len(alike), size := 1):",
        f"{OF_MPM}/test_batch.py",
        "test_a_batch_does_not_change_a_bit[1]",
    ),
    Mutation(
        "a batch whatever the processor's cache holds",
        "mpm_warp/batch.py",
        "size = max(1, POINTS_IN_CACHE // max(1, alike[0].plan.particle_count))",
        "size = 1000",
        f"{OF_MPM}/test_batch.py",
        "test_a_batch_larger_than_the_cache_is_taken_in_portions",
    ),
    Mutation(
        "soil taken for parted where it is pressed",
        "mpm_warp/contact.py",
        "forces > self._parting_forces",
        "forces < self._parting_forces",
        f"{OF_MPM}/test_penetrometer.py",
        "test_the_share_in_touch_is_of_the_area_that_something_presses",
    ),
    Mutation(
        "twice the work of the penetrometer",
        "mpm_warp/penetration.py",
        "self.work += force.upward",
        "self.work += 2.0 * force.upward",
        f"{OF_MPM}/test_penetration.py",
        "test_forces_and_work_are_those_of_the_nodes_along_the_axis",
    ),
    Mutation(
        "bound of Poisson's ratio left out",
        "mpm_warp/scenes/cone_penetration.py",
        "min(self.poissons_ratio, self.poissons_ratio_bound)",
        "self.poissons_ratio",
        f"{OF_MPM}/test_cone_penetration.py",
        "test_poissons_ratio_is_simulated_up_to_its_bound",
    ),
    Mutation(
        "surface of points with a share of its area twice",
        "mpm_warp/immersed.py",
        "face = self._sum((0.0, tip)",
        "face = 2.0 * self._sum((0.0, tip)",
        f"{OF_MPM}/test_immersed.py",
        "test_areas_of_face_and_shaft_are_exact",
    ),
    Mutation(
        "energy of every audited step taken once",
        "mpm_warp/simulation.py",
        "return AUDIT_INTERVAL * float",
        "return float",
        f"{OF_MPM}/test_health.py",
        "test_energy_audit_is_a_sample_of_what_the_transfers_do",
    ),
    Mutation(
        "double precision in a kernel of single precision",
        "mpm_warp/kernels/window.py",
        "risen = speed *",
        "risen = wp.float64(speed) *",
        f"{OF_MPM}/test_gpu.py",
        "test_every_kernel_compiles_for_a_gpu_alone_and_over_cases",
    ),
    Mutation(
        "steady at twice the tolerance",
        "mpm_warp/steady_state.py",
        "< tolerance * abs(last)",
        "< 2.0 * tolerance * abs(last)",
        f"{OF_MPM}/test_steady_state.py",
        "test_what_is_left_of_an_exponential_is_what_its_decay_says",
    ),
    Mutation(
        "files written under their own name",
        "harness/whole_files.py",
        "    partial = _partial(path)\n",
        "    partial = path\n",
        "tests/harness/test_whole_files.py",
        "test_a_process_killed_as_it_writes_leaves_the_earlier_file_and_one_to_be_removed",
    ),
    Mutation(
        "a tolerance that is kept by what is not a number",
        "harness/gate.py",
        "not size <= limit",
        "size > limit",
        "tests/harness/test_gate.py",
        "test_what_failed_is_missed",
    ),
    Mutation(
        "cases that are done run again",
        "harness/run_study.py",
        "return outcome.status == COMPLETED and",
        "return False and",
        "tests/harness/test_run.py",
        "test_running_again_goes_on_where_it_stopped",
    ),
)


def outcome(tree: Path, nodes: Iterable[str], time_limit: float | None) -> tuple[str, str]:
    """What becomes of tests in a tree: `PASSED`, `FAILED` or in other words what else; and why."""
    with subprocess.Popen(
        [sys.executable, "-m", "pytest", "-q", "--tb=no", "-rfE", *nodes],
        cwd=tree,
        env=os.environ
        | {"PYTHONPATH": str(tree), "WARP_CACHE_PATH": str(tree.parent / "cache")}
        | {"COLUMNS": "200"},  # else there is no room for reasons
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    ) as pytest:
        try:
            told, _ = pytest.communicate(timeout=time_limit)
        except BaseException as error:
            os.killpg(pytest.pid, signal.SIGKILL)
            if isinstance(error, subprocess.TimeoutExpired):
                return "timed out", ""
            raise
    reasons = [line for line in told.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    reason = reasons[0].partition(" - ")[2] if reasons else ""
    if pytest.returncode == 0:
        return PASSED, ""
    if pytest.returncode == 1 and all(line.startswith("FAILED ") for line in reasons):
        return FAILED, reason
    return f"ended with {pytest.returncode}", reason


def copied(folder: Path) -> Path:
    """A copy of the tree in a folder, new."""
    tree = folder / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    tree.mkdir()
    for name in COPIED:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tree / name)
    return tree


def main(words: list[str]) -> int:
    """Try every error, or those with one of the words; returns the exit code."""
    tried = [it for it in MUTATIONS if not words or any(word in it.meaning for word in words)]
    lines = [
        "# Deliberate errors and the test that notices each",
        "",
        "Written by `python tests/mutations.py`.",
        "",
        "| error | file | test |",
        "|---|---|---|",
    ]
    unnoticed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sound, _ = outcome(copied(folder), dict.fromkeys(it.node for it in tried), None)
        if sound != PASSED:
            raise SystemExit(f"without an error the tests {sound}")
        for mutation in tried:
            tree = copied(folder)
            mutation.apply(tree)
            said, reason = outcome(tree, [mutation.node], TIME_LIMIT)
            unnoticed += said != FAILED
            noticed = f"`{mutation.test}`" if said == FAILED else f"**unnoticed**: {said}"
            lines.append(f"| {mutation.meaning} | `{mutation.file}` | {noticed} |")
            print(lines[-1], reason, flush=True)
    if not words:
        TABLE.write_text("\n".join(lines) + "\n")
    return 1 if unnoticed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
