"""The time of a step of newton's implicit material points, for a block of clay on the ground.

    python newton_step.py POINTS STEPS

The block is a cube of 1 m with 8 points a cell; su is 20 kPa, Ir 100, the density 2000 kg/m3. It
prints the updates of points per second and the iterations of a step, medians of the steps after the
first, which compiles.
"""

import contextlib
import io
import re
import sys
import time

import newton
import numpy as np
import warp as wp
from newton.solvers import SolverImplicitMPM

STRENGTH, RIGIDITY_INDEX, POISSONS_RATIO, DENSITY = 2e4, 100.0, 0.49, 2000.0
TIME_STEP = 1.0 / 60.0  # of its example of a heap of sand [s]

points, step_count = int(sys.argv[1]), int(sys.argv[2])
wp.set_device("cpu")
along_edge = 2 * round((points / 8) ** (1 / 3))
spacing = 1.0 / along_edge
builder = newton.ModelBuilder()
SolverImplicitMPM.register_custom_attributes(builder)
builder.add_particle_grid(
    pos=wp.vec3(0.5 * spacing),
    rot=wp.quat_identity(),
    vel=wp.vec3(0.0),
    dim_x=along_edge,
    dim_y=along_edge,
    dim_z=along_edge,
    cell_x=spacing,
    cell_y=spacing,
    cell_z=spacing,
    mass=DENSITY * spacing**3,
    jitter=0.0,
    radius_mean=0.5 * spacing,
    custom_attributes={
        "mpm:young_modulus": 2 * (1 + POISSONS_RATIO) * RIGIDITY_INDEX * STRENGTH,
        "mpm:poisson_ratio": POISSONS_RATIO,
        "mpm:friction": 0.0,
        "mpm:yield_stress": STRENGTH,
    },
)
builder.add_ground_plane()
model = builder.finalize()
config = SolverImplicitMPM.Config(voxel_size=2 * spacing, grid_type="dense")
solver = SolverImplicitMPM(model, config, verbose=True)
before, after = model.state(), model.state()
seconds, iterations = [], []
for _ in range(step_count + 1):
    start = time.perf_counter()
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        solver.step(before, after, None, None, TIME_STEP)
    wp.synchronize()
    seconds.append(time.perf_counter() - start)
    iterations.append(int(re.findall(r"iteration #(\d+)", printed.getvalue())[-1]))
    before, after = after, before
rate = model.particle_count / np.median(seconds[1:])
print(f"{model.particle_count} points, {rate:.3g} updates per second,", end=" ")
print(f"{np.median(iterations[1:]):.0f} iterations a step")
