"""What `import mpm_warp` offers, and what it costs."""

import inspect
import subprocess
import sys

import pytest

import mpm_warp
from mpm_warp import public_names, scene_class, scene_names
from tests.conftest import finished

pytestmark = pytest.mark.slow


def run(code: str) -> subprocess.CompletedProcess[str]:
    return finished([sys.executable, "-c", code])


def test_every_scene_and_what_scenes_are_made_of_is_there() -> None:
    names = set(dir(mpm_warp))
    assert {scene_class(name).__name__ for name in scene_names()} <= names
    assert names >= {
        *("Scene", "Simulation", "Execution", "Grid", "PolarGrid"),
        *("Anisotropic", "EinavRandolph", "LinearElastic", "ModifiedCamClay", "Tresca", "VonMises"),
        *("SurfaceContact", "FarField", "Fixed", "Window", "MovingWall", "RadialMotion"),
        *("Gravity", "NodalLoad", "Damping"),
        *("SceneError", "ParameterError", "SimulationDiverged", "InaccurateRun"),
    }


def test_each_public_name_is_typed_documented_and_that_of_its_class() -> None:
    for name in dir(mpm_warp):
        value = getattr(mpm_warp, name)
        assert value.__name__ == name
        listed = getattr(public_names, name)
        assert listed is value
        documented = inspect.getdoc(value)
        assert documented, name
        assert not documented.startswith("See "), name


@pytest.mark.parametrize(
    ("name", "nearest"), [("ConePenetraton", "ConePenetration"), ("scene_nams", "scene_names")]
)
def test_an_unknown_name_is_refused_with_the_nearest(name: str, nearest: str) -> None:
    with pytest.raises(AttributeError, match=f"no attribute '{name}'; did you mean '{nearest}'"):
        getattr(mpm_warp, name)


def test_the_import_alone_brings_no_simulator_and_all_names_come_at_once() -> None:
    """Modules are not names, and import as they do everywhere."""
    assert not hasattr(mpm_warp, "_no_such_name")
    done = run(
        "import sys, mpm_warp; print({'warp', 'numpy', 'xarray'} & set(sys.modules))\n"
        "from mpm_warp import fields, scene; print(fields.__name__, scene.__name__)\n"
        "del sys, mpm_warp, fields, scene\n"
        "from mpm_warp import *; print(*(name for name in dir() if name[0] != '_'))"
    )
    brought, modules, names = done.stdout.splitlines()
    assert (brought, modules) == ("set()", "mpm_warp.fields mpm_warp.scene")
    assert names.split() == dir(mpm_warp)


def test_a_run_is_silent() -> None:
    """Neither Warp's greeting, nor its remark where there is no GPU, nor its loading of modules."""
    done = run("from mpm_warp import GravityColumn; GravityColumn(cell_count=2).run()")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_what_the_user_has_asked_warp_to_tell_is_kept() -> None:
    code = "import warp; warp.config.log_level = warp.LOG_DEBUG; import mpm_warp.kernel_types; "
    assert run(code + "print(warp.config.log_level == warp.LOG_DEBUG)").stdout.endswith("True\n")
