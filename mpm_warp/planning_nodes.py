"""What only some scenes have: what acts on the nodes between momentum equation and particles.

Each function adds the arrays of one part of the scene, and its launch.
"""

from __future__ import annotations

from mpm_warp.parts.boundaries import FarField, Fixed
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.boundary_kernels import make_far_field, make_fixed
from mpm_warp.parts.contact_law import make_surface_contact
from mpm_warp.parts.load_kernels import make_damping, make_gravity, make_nodal_load
from mpm_warp.parts.loads import NodalLoad
from mpm_warp.plan.plan import OFFSET, Plan


def add_actions_on_nodes(plan: Plan) -> None:
    """What changes the velocities that the momentum equation gives, in this order."""
    scene = plan.scene
    if scene.load is not None:
        _add_load(plan, scene.load)
    if scene.gravity is not None:
        _add_gravity(plan, scene.gravity)
    if scene.damping is not None:
        _add_damping(plan, scene.damping)
    if scene.fixed is not None:
        _add_fixed(plan, scene.fixed)
    if scene.far_field is not None:
        _add_far_field(plan, scene.far_field)
    if scene.contact is not None:
        _add_contact(plan, scene.contact)


def _add_load(plan: Plan, load: NodalLoad) -> None:
    """Forces on nodes."""
    plan.add_array("load.nodes", "int", load.nodes)
    plan.add_array("load.forces", "vec2", load.forces)
    plan.add_launch(
        make_nodal_load(plan.precision),
        len(load.nodes),
        *("load.nodes", "load.forces", "node.mass", plan.time_step, "node.motion"),
    )


def _add_gravity(plan: Plan, gravity: float) -> None:
    """The weight of the soil."""
    kernel = make_gravity(plan.precision)
    count = plan.scene.grid.node_count
    plan.add_launch(kernel, count, OFFSET, gravity * plan.time_step, "node.mass", "node.motion")


def _add_damping(plan: Plan, damping: float) -> None:
    """A force against all motion."""
    kernel = make_damping(plan.precision)
    count = plan.scene.grid.node_count
    plan.add_launch(kernel, count, OFFSET, damping * plan.time_step, "node.motion")


def _add_fixed(plan: Plan, fixed: Fixed) -> None:
    """Nodes at rest."""
    plan.add_array("fixed.nodes", "int", fixed.nodes)
    plan.add_array("fixed.free", "vec2", fixed.free)
    kernel = make_fixed(plan.precision)
    plan.add_launch(kernel, len(fixed.nodes), OFFSET, "fixed.nodes", "fixed.free", "node.motion")


def _add_far_field(plan: Plan, far_field: FarField) -> None:
    """Springs and dashpots in the place of the ground beyond the grid."""
    count = len(far_field.nodes)
    plan.add_array("far_field.nodes", "int", far_field.nodes)
    plan.add_array("far_field.spring", "real", far_field.spring)
    plan.add_array("far_field.dashpot", "vec2", far_field.dashpot)
    plan.add_zeros("far_field.displacement", "real", count)
    plan.add_launch(
        make_far_field(plan.precision),
        count,
        OFFSET,
        *("far_field.nodes", "far_field.spring", "far_field.dashpot"),
        *("node.mass", plan.time_step, "far_field.displacement", "node.motion"),
    )


def _add_contact(plan: Plan, contact: SurfaceContact) -> None:
    """The contact law at the surface of the body."""
    pressure_forces = contact.in_situ_stress * contact.normal_areas
    plan.add_array("contact.nodes", "int", contact.nodes)
    plan.add_array("contact.normals", "vec2", contact.normals)
    plan.add_array("contact.adhesion", "real", contact.adhesion_forces)
    plan.add_array("contact.pressure", "real", pressure_forces)
    plan.add_zeros("contact.impulse", "vec2", len(contact.nodes))
    window = None if plan.scene.window is None else "window.motion"
    plan.add_launch(
        make_surface_contact(window is not None, plan.precision),
        len(contact.nodes),
        OFFSET,
        *("contact.nodes", "contact.normals", contact.friction),
        *("contact.adhesion", "contact.pressure", "node.mass", plan.time_step),
        *(contact.speed, window),
        *("node.motion", "contact.impulse"),
    )
