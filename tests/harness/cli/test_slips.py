"""Mistakes in a command line: each is answered in one line that says what to do, and not done."""

import shlex
from pathlib import Path

import pytest

from tests.harness.conftest import Refusal

FILES = {
    "site.toml": 'title = "t"\n[test]\nfile = "cpt.csv"\n',
    "file.txt": "",
    "-dash.toml": "",
    "text.toml": 'title = "t"\nscene = cone_penetration\n',
    "comma.toml": 'title = "t"\nscene = "cone_penetration"\n[fixed]\nadhesion_factor = 0,5\n',
    "colon.toml": 'title = "t"\nscene: "cone_penetration"\n',
    "list.toml": 'title = "t"\nscene = "cone_penetration"\n[fixed]\nadhesion_factor = [0, 1]\n',
    "single.toml": 'title = "t"\nscene = "cone_penetration"\n[vary]\nadhesion_factor = 0.5\n',
    "yielding.toml": 'title = "t"\nscene = "cone_penetration"\n[fixed]\nmaterial = "von_mises"\n'
    "stress_anisotropy = 0.9\n",
    "derived.toml": 'title = "t"\nscene = "cone_penetration"\n[derived]\ndensity = "su / G"\n',
}
COUNT = "must be an integer from 1 to 999999"
MISTAKES = {
    "run cone_penetration": "is a scene; a study says what to vary in it: `harness new my_study "
    "--scene cone_penetration` writes one, `harness run my_study.toml` runs it",
    "run adhesion_facotr": "no such study; did you mean 'adhesion_factor'?",
    "run cone": "no such study; did you mean 'cone_penetration'?",
    "describe von_misses": "neither a scene nor a study; did you mean 'von_mises'?",
    "describe cone": "neither a scene nor a study; did you mean 'cone_penetration'?",
    "rnu adhesion_factor": "rnu: is not a command; did you mean 'run'?",
    "adhesion_factor": "is a study, not a command; `harness run adhesion_factor` runs it",
    "run text": "text: no such study; a file here is called text.toml",
    "run text.toml": 'a text needs quotes: scene = "cone_penetration"',
    "run comma.toml": "a number has a decimal point: adhesion_factor = 0.5",
    "run colon.toml": "write = between a key and its value",
    "run list.toml": "is a list; what varies belongs under [vary]",
    "run single.toml": "must be a list of values, or a range; a single value belongs",
    "run derived.toml": "give 'rigidity_index', G / su",
    "run mesh_size --set G=2e6": "unknown parameter 'G'; give 'rigidity_index', G / su",
    "run mesh_size --set shear_modulus=2e6": "give 'rigidity_index', G / su",
    "run mesh_size --set su=35e3": "unknown parameter 'su'; give 'undrained_shear_strength', in Pa",
    "run mesh_size --set alpha=0.5": "give 'adhesion_factor', adhesion over su, 0 smooth to 1",
    "run mesh_size --set Ir=100": "unknown parameter 'Ir'; give 'rigidity_index', G / su",
    "run mesh_size --set Nc=10": "unknown parameter 'Nc'; it is a result, not a parameter",
    "run mesh_size --set undrained_shear_strength=35kPa": "give the number without kPa, in the "
    "unit of the parameter",
    "run mesh_size --set penetration=0.3": "must be a number >= 1 and <= 1000; meaning: greatest "
    "penetration over cone radius",
    "run mesh_size --set adhesion_factor=[0, 1]": "the shell has split the value at a blank; put "
    "quotes around it: --set 'adhesion_factor=[0, 1]'",
    "run mesh_size --set=adhesion_factor=[0, 1]": "--set 'adhesion_factor=[0, 1]'",
    "run mesh_size --set adhesion_factor=[0,": "a bracket is not closed",
    "run mesh_size --set adhesion_factor=0,1": "brackets: 'adhesion_factor=[0,1]'",
    "run mesh_size --set material=von mises": "mises; put quotes around a value with blanks",
    "run mesh_size --set material=von-mises": "two kinds of quotes: 'material=\"von-mises\"'",
    "run mesh_size --set material=[tresca,von_mises]": "a text in it needs quotes: "
    '\'material=["tresca","von_mises"]\'',
    "run mesh_size --set material={law=tresca}": "needs quotes: 'material={law=\"tresca\"}'",
    "run mesh_size --set material.phi=30": "give 'material.critical_state_ratio', 6 sin(phi)",
    "run mesh_size rigidity_index=50": "change a parameter by --set rigidity_index=50",
    "run mesh_size --set rigidity_index": "must be key=value",
    "run mesh_size --set rigidity_index=": "must be key=value",
    "run mesh_size --set =1": "must be key=value",
    "run mesh_size --set adhesion_factor='1\ndensity=2'": "not a TOML value",
    "run overconsolidation --set stress_anisotropy=0.6": "isotropic_overconsolidation_ratio = 1 "
    "must be >= 1.11: the stress of the ground is outside the yield surface",
    "describe yielding.toml": "vertical and horizontal stress differ by 36000 Pa, which must be <= "
    "34641 Pa in compression",
    "plan strength_anisotropy --set stress_anisotropy=-0.5 --set remoulded_strength_ratio=0.9 "
    "--set ductility=10": "differ by 20000 Pa, which must be <= 16000 Pa in extension",
    "run there/mesh_sizes.toml": "no such file; did you mean 'mesh_size'?",
    "run folder.toml": "not a file",
    "run file.txt": "no such study",
    "run ./file.txt": "is called NAME.toml",
    "run ./-dash.toml": "with neither '-' nor '.' first",
    "run mesh_size --fres": "unrecognized arguments: --fres; did you mean '--fresh'?",
    "plan adhesion_facotr": "neither a scene nor a study; did you mean 'adhesion_factor'?",
    "new adhesion_factor": "a study that ships has this name; choose another",
    "new text": "text.toml: exists already; edit it, or choose another name",
    "new a/b": "is not a valid name; use letters, digits, '_', '-' and '.'",
    "new Con": "no device of Windows",
    "new com1.soft": "no device of Windows",
    "new clay.": "no '.' last",
    "new mine --scene mesh_size": "--scene mesh_size: is a study; its scene is cone_penetration",
    "new mine --scene sounding --interpret cpt.csv": "not allowed with argument --scene",
    "new mine --scene cone_bering": "unknown scene 'cone_bering'; did you mean 'cone_bearing'?",
    "status": "results: has no results; `harness run STUDY` writes some",
    "status strip_footing": "results: has no results of strip_footing",
    "compare text.toml": "cannot be read",
    "results/mesh_size.nc": "is a result, not a command; `harness compare",
    "report a.nc -o b.nc": "'b.nc' is not allowed: must end in .html",
    "compare a.nc b.nc --tolerance=-1": "must be a number >= 0",
    "compare a.nc --tolerance=0.5": "needs a second result OTHER",
    "status --traceback": "need a study; name it, or leave them out",
    "status a.nc --set rigidity_index=50": "need a study; name it, or leave them out",
    "benchmark run a --against b": "--against is only for score; leave it out",
    "benchmark score --accuracy fine": "--accuracy is only for run; leave it out",
    "run site.toml": "site.toml: this is a site file; `harness interpret site.toml` reads it",
    "interpret single.toml": "single.toml: is a study; `harness run single.toml` runs it",
    "recommend s --error=0%": "'0%' is not allowed: must be > 0, as 1% or 0.01",
    "recommend s --error 1": "'1' is 100%: is 1% meant?",
    "recommend thick_cylinder --error 1% --results no": "harness: --results no: no such folder",
    "run mesh_size --out file.txt": "file.txt: is not a folder",
    "run mesh_size --out file.txt/below": "file.txt/below: is not a folder",
    "run mesh_size --threads=3": "choose from 1, 2, 4",
    "run mesh_size --device=cuda:7": "--device cuda:7: there is none here; known: cpu",
    "run mesh_size --threads=2 --dask=tcp://h:1": "leave them out with --dask",
    "run bench --workers=2": "cases are timed one at a time, without --workers",
    "verify --scene cone_penetration": "has no exact solution",
    "verify --scene flying_block": "add --extreme",
    "verify --scene gravity_column --extreme": "no extreme check",
    "verify --scene t_bar_penetration --quick": "takes less than 20 s; leave it out",
}
WRONG = {
    "run mesh_size --workers": (COUNT, ("0", "-1", "two", "1.5", "9" * 5000)),
    "run mesh_size --case-timeout": (
        "is not allowed: must be a number > 0",
        ("0", "-1", "soon", "nan", "inf"),
    ),
    "run mesh_size --memory-limit": (
        "must be 100MB at least, as 8e9 or 8GB",
        ("0", "8", "-1GB", "much", "GB", "inf", "nan"),
    ),
}
"""Options, what is told of them, and values that are wrong."""
MISTAKES |= {f"{of}={value}": told for of, (told, them) in WRONG.items() for value in them}
MEASURED = "ball_penetration, cone_penetration, sounding, t_bar_penetration"
MISTAKES |= {
    f"run {of} --uncertainty": f"cannot be measured for {of}, only for: {MEASURED}"
    for of in ("sliding_block", "cyclic_ball")
}
"""Command lines as a shell hands them on, and what the answer ends with or holds."""


@pytest.mark.parametrize("line", MISTAKES)
def test_a_mistake_is_answered_by_what_to_do(line: str, here: Path, refusal: Refusal) -> None:
    for name, text in FILES.items():
        Path(name).write_text(text, encoding="utf-8")
    Path("folder.toml").mkdir()
    assert MISTAKES[line] in refusal(shlex.split(line))
    assert set(here.iterdir()) == {here / name for name in (*FILES, "folder.toml")}
