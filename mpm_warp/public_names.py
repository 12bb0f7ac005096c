"""The public names of `mpm_warp`, which imports this module when the first of them is used."""

from mpm_warp.bodies.body import Body, InterfaceFrame, Load, UniformGrid
from mpm_warp.bodies.contact import BodyContact
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.errors import (
    InaccurateRun,
    ParameterError,
    SceneError,
    SimulationDiverged,
    UnfinishedRun,
    UnknownSceneError,
    WindowOverfull,
)
from mpm_warp.execution.execution import Execution
from mpm_warp.fields.checked import Group
from mpm_warp.fields.declaration import group, parameter, redefined
from mpm_warp.grid.fitted import Grid
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.materials.anisotropic import Anisotropic
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.elasticity import Isotropic, LinearElastic
from mpm_warp.materials.material import Material
from mpm_warp.materials.modified_cam_clay import ModifiedCamClay
from mpm_warp.materials.tresca import Tresca
from mpm_warp.materials.variation import Variation
from mpm_warp.materials.von_mises import VonMises
from mpm_warp.parts.boundaries import FarField, Fixed, RadialMotion
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.cyclic_window import CyclicWindow
from mpm_warp.parts.enclosed_soil import EnclosedSoil
from mpm_warp.parts.energy import EnergyAudit, EnergyBalance
from mpm_warp.parts.forces import Damping, Gravity, NodalLoad
from mpm_warp.parts.free_surface import FreeSurface, PassingSurface
from mpm_warp.parts.history import History
from mpm_warp.parts.interpolation import ConservativeInterpolation
from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.parts.surrounding_ground import SurroundingGround, TravellingSource
from mpm_warp.parts.window import Approach, Window
from mpm_warp.results import Drawn, curves, labelled
from mpm_warp.sampling import ContactForces, Samples, follow
from mpm_warp.scene import Part, Scene
from mpm_warp.scenes.bearing.on_ground import CircularFooting, ConeBearing, StripFooting
from mpm_warp.scenes.blocks.flying_block import FlyingBlock
from mpm_warp.scenes.blocks.sliding_block import SlidingBlock
from mpm_warp.scenes.catalogue import scene_class, scene_names
from mpm_warp.scenes.catalogue_scene import CatalogueScene
from mpm_warp.scenes.cavity.shapes import CavityCylinder, CavitySphere
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.cone_self_similar import ConeSelfSimilar
from mpm_warp.scenes.elastic.column_wave import ElasticColumnWave
from mpm_warp.scenes.elastic.columns import GravityColumn
from mpm_warp.scenes.elastic.impact import StruckBar, StruckColumn
from mpm_warp.scenes.elastic.stretched_bar import StretchedBar
from mpm_warp.scenes.elastic.thick_cylinder import ThickCylinder
from mpm_warp.scenes.full_flow.cyclic import CyclicBall, CyclicTBar
from mpm_warp.scenes.full_flow.limit_load import FullFlowCylinder, FullFlowSphere
from mpm_warp.scenes.full_flow.penetration import BallPenetration, TBarPenetration
from mpm_warp.scenes.limits import Limit, limited
from mpm_warp.scenes.material.element_test import ElementTest
from mpm_warp.scenes.material.material_point import MaterialPoint
from mpm_warp.scenes.run_size import RunSize
from mpm_warp.scenes.sounding.profile import Profile
from mpm_warp.scenes.sounding.sounding import Sounding
from mpm_warp.scenes.step_cost import StepCost
from mpm_warp.scenes.verification import Verification, compared
from mpm_warp.simulation import Simulation
from mpm_warp.snapshots import Snapshots, soil_fields
