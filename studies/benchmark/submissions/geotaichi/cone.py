"""Phase 2, case 1 in GeoTaichi: a smooth cone of 60 degrees is pushed into weightless clay, Ir 100.

    python cone.py CELLS_PER_RADIUS DEPTH SPEED_RATIO

R is 1 m and su 1 kPa. Each quarter of a radius it prints the depth of the tip over R, qc / su as
the mean over that quarter of the vertical contact force over the base area, and the updates of
points per second, which in the first quarter have the compilation in them. The ground has no stress
at the start, and the cone starts at its surface.
"""

import math
import sys
import time

import taichi as ti
from geotaichi import MPM, init

STRENGTH, RIGIDITY_INDEX, POISSONS_RATIO, DENSITY = 1e3, 100.0, 0.49, 1e3
WIDTH, GROUND, SHAFT = 20.0, 40.0, 23.0
SPAN = 0.25

cells, depth, speed_ratio = int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3])
shear_modulus = RIGIDITY_INDEX * STRENGTH
speed = speed_ratio * math.sqrt(shear_modulus / DENSITY)
pressure_modulus = 2 * shear_modulus * (1 - POISSONS_RATIO) / (1 - 2 * POISSONS_RATIO)
size, height = 1.0 / cells, GROUND + SHAFT + 1.0

init(dim=2, arch="cpu", cpu_max_num_threads=1, log=False)
mpm = MPM()
mpm.set_configuration(
    domain=[WIDTH, height],
    is_2DAxisy=True,
    gravity=[0.0, 0.0],
    alphaPIC=0.01,
    mapping="MUSL",
    shape_function="GIMP",
    stabilize="B-Bar Method",
)
mpm.set_solver(
    {
        "Timestep": 0.4 * size / math.sqrt(pressure_modulus / DENSITY),
        "SimulationTime": SPAN / speed,
        "SaveInterval": 1e9,
    }
)
mpm.memory_allocate(
    {
        "max_material_number": 1,
        "max_particle_number": 4 * cells**2 * int(WIDTH * GROUND + 2 * SHAFT),
        "max_constraint_number": {"max_velocity_constraint": 8 * cells * int(WIDTH + height)},
    }
)
mpm.add_contact(contact_type="MPMContact", friction=0.0)
mpm.add_material(
    "MohrCoulomb",
    {
        "MaterialID": 1,
        "Density": DENSITY,
        "YoungModulus": 2 * (1 + POISSONS_RATIO) * shear_modulus,
        "PoissonRatio": POISSONS_RATIO,  # in capitals and letters as here: another key is ignored
        "Cohesion": STRENGTH,
        "Friction": 0.0,
        "Dilation": 0.0,
    },
)
mpm.add_element({"ElementType": "Q4N2D", "ElementSize": [size, size]})
boxes = {
    "clay": ("Rectangle2D", [0.0, 0.0], [WIDTH, GROUND]),
    "cone": ("Cone2D", [0.0, GROUND], [1.0, SHAFT]),
}
for name, (kind, corner, extent) in boxes.items():
    mpm.add_region(
        {"Name": name, "Type": kind, "BoundingBoxPoint": corner, "BoundingBoxSize": extent}
    )
clay = {"RegionName": "clay", "nParticlesPerCell": 2, "BodyID": 0, "MaterialID": 1}
rigid = {"BodyID": 1, "RigidBody": True, "Density": DENSITY, "FixVelocity": ["Fix", "Fix"]}
cone = {"RegionName": "cone", "nParticlesPerCell": 2, "InitialVelocity": [0.0, -speed], **rigid}
mpm.add_body({"Template": [clay, cone]})
held = {
    "bottom": ([None, 0.0], [0.0, 0.0], [WIDTH, 0.0]),
    "axis": ([0.0, None], [0.0, 0.0], [0.0, height]),
    "side": ([0.0, None], [WIDTH, 0.0], [WIDTH, height]),
}
for velocity, begin, end in held.values():
    line = {"Velocity": velocity, "StartPoint": begin, "EndPoint": end}
    mpm.add_boundary_condition([{"BoundaryType": "VelocityConstraint", **line}])
mpm.select_save_data(particle=False, grid=False, object=False)

force, steps = ti.field(float, shape=()), ti.field(int, shape=())


def add_force():
    """Of the nodes of the cone, after each step; GeoTaichi compiles it."""
    for node in range(mpm.scene.node.shape[0]):
        force[None] += mpm.scene.node[node, 1].contact_force[1]
    steps[None] += 1


for span in range(1, round(depth / SPAN) + 1):
    mpm.modify_parameters(SimulationTime=span * SPAN / speed, SaveInterval=1e9)
    start = time.perf_counter()
    mpm.run(**({"function": add_force} if span == 1 else {}))
    rate = int(mpm.scene.particleNum[0]) * steps[None] / (time.perf_counter() - start)
    # Forces of GeoTaichi are per radian: the base area is R^2 / 2.
    factor = 2.0 * force[None] / steps[None] / STRENGTH
    print("result", span * SPAN, factor, f"{rate:.3g}", flush=True)
    force[None], steps[None] = 0.0, 0
