"""Studies and settings that are wrong: each is refused in one line, nothing is written."""

from pathlib import Path

import pytest

from harness.cli.main import main
from harness.study.study import load_study
from mpm_warp.parameters import parameters_of
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from tests.harness.conftest import Refusal

GOOD = 'title = "t"\nscene = "cone_penetration"\n'
ALLOWED = {name: it.allowed for name, it in parameters_of(ConePenetration).items()}
SCENE_ONLY = 'scene = "cone_penetration"\n'

MANY = list(range(1001, 2001))

# What is wrong: the definition, and what the message must contain.
MALFORMED: dict[str, tuple[str | bytes, str]] = {
    "misspelt parameter": (
        GOOD + "[fixed]\nadhesion_factr = 1",
        "[fixed] adhesion_factr = 1: unknown parameter 'adhesion_factr'; did you mean 'adhesion_",
    ),
    "above the range": (GOOD + "[fixed]\nadhesion_factor = 1.5", "adhesion_factor = 1.5 is not"),
    "at an open bound": (
        GOOD + "[fixed]\npoissons_ratio = 0.5",
        f"must be {ALLOWED['poissons_ratio']}",
    ),
    "one of a list": (GOOD + "[vary]\nadhesion_factor = [0, 2]", "[vary] adhesion_factor = 2"),
    "not finite": (GOOD + "[fixed]\ndensity = inf", "density = inf is not allowed"),
    "not a number": (GOOD + "[fixed]\ndensity = nan", "density = nan is not allowed"),
    "text for a number": (GOOD + '[fixed]\ndensity = "1"', "density = '1' is not allowed"),
    "truth for a number": (GOOD + "[fixed]\ndensity = true", "density = True is not allowed"),
    "date for a number": (GOOD + "[fixed]\ndensity = 2026-01-01", f"must be {ALLOWED['density']}"),
    "table for a number": (GOOD + "[fixed.density]\na = 1", f"must be {ALLOWED['density']}"),
    "fraction for an integer": (
        GOOD + "[fixed]\nparticles_per_cell = 4.5",
        f"must be {ALLOWED['particles_per_cell']}",
    ),
    "choice misspelt": (GOOD + '[fixed]\nmaterial = "treska"', "did you mean 'tresca'?"),
    "integer of 80 bits": (GOOD + f"[fixed]\ndensity = {2**80}", f"must be {ALLOWED['density']}"),
    "integer of 20000 digits": (GOOD + "[fixed]\ndensity = 0x" + "f" * 20000, "too long to show"),
    "decimal of 5000 digits": (GOOD + "[fixed]\ndensity = " + "1" * 5000, "not valid TOML"),
    "list among the fixed": (GOOD + "[fixed]\ndensity = [1, 2]", "belongs under [vary]"),
    "scalar among the varied": (GOOD + "[vary]\ndensity = 1", "must be a list"),
    "empty list": (GOOD + "[vary]\ndensity = []", "must be a list of one value or more"),
    "a value twice": (GOOD + "[vary]\ndensity = [1, 2, 1.0]", "1.0 is there twice"),
    "the same value in a large list": (
        GOOD + f"[vary]\ndensity = {[*range(1, 60_001), 60_000]}",
        "60000.0 is there twice",
    ),
    "key of many parts": (GOOD + "a" + ".a" * 300_000 + " = 1", "a key has more than 20 parts"),
    "many conditions": (
        GOOD + f"exclude = {101 * ['density > 1']}",
        "has 101 conditions; a study has at most 100; join them by `or`",
    ),
    "nested list": (GOOD + "[vary]\ndensity = [[1]]", "density = [1]"),
    "fixed and varied": (GOOD + "[fixed]\ndensity = 1\n[vary]\ndensity = [1]", "as well"),
    "unknown table": (GOOD + "[varry]\ndensity = [1]", "unknown key; did you mean 'vary'?"),
    "unknown key": (GOOD + "scenne = 1", "unknown key; did you mean 'scene'?"),
    "unknown key to compare": (GOOD + "[compare]\nreference = []", "did you mean 'references'?"),
    "unknown reference": (GOOD + '[compare]\nreferences = ["lu_2005"]', "did you mean 'lu_2004'?"),
    "reference of wrong type": (GOOD + "[compare]\nreferences = [{}]", "unknown reference {}"),
    "references not a list": (GOOD + '[compare]\nreferences = "lu_2004"', "must be a list"),
    "reference twice": (
        GOOD + '[compare]\nreferences = ["lu_2004", "lu_2004"]',
        "names a reference twice",
    ),
    "table that is none": ("fixed = 1\n" + GOOD, "must be a table [fixed]"),
    "unknown scene": ('title = "t"\nscene = "cone_penetratoin"', "did you mean 'cone_penetration'"),
    "scene of wrong type": ('title = "t"\nscene = 1', "scene = 1: must be a text"),
    "no scene": ('title = "t"', "scene: is missing; known: "),
    "no title": (SCENE_ONLY, "title: is missing"),
    "title without end": (
        SCENE_ONLY + f'title = "{"a" * 900_000}"',
        "has 900000 characters; a text has at most 1000",
    ),
    "title of two lines": (SCENE_ONLY + 'title = "a\\nb"', "must be a text of one line"),
    "timing of wrong type": (GOOD + "[timing]\nrepeats = 2.0", "repeats = 2.0: must be an integer"),
    "truth for repeats": (GOOD + "[timing]\nrepeats = true", "must be an integer, 1 to 1000"),
    "no repeats": (GOOD + "[timing]\nrepeats = 0", "must be an integer, 1 to 1000"),
    "unknown key to timing": (GOOD + "[timing]\nrepeat = 2", "did you mean 'repeats'?"),
    "empty": ("", "is missing"),
    "syntax error": (GOOD + "[fixed\n", "not valid TOML: Expected"),
    "key twice": (GOOD + 'title = "again"', "not valid TOML: Cannot overwrite"),
    "line break in a key": (GOOD + '[fixed]\n"a\\nb" = 1', r"a\nb"),
    "not UTF-8": (b'title = "\xff"', "not UTF-8 at byte 9"),
    "nested deeply": ("a = " + "[" * 20000, "nested too deeply"),
    "dotted deeply": (
        GOOD + "fixed.density" + ".a" * 3000 + " = 1",
        "a key has more than 20 parts",
    ),
    "too large": (GOOD + "#" * 2_000_000, "a study has at most"),
    "too many cases": (
        GOOD + f"[vary]\ndensity = {MANY}\nundrained_shear_strength = {MANY}",
        "gives 1000000 cases",
    ),
}
BAD_SETTINGS = {
    "misspelt": ("adhesion_factr=1", "did you mean 'adhesion_factor'?"),
    "out of range": ("adhesion_factor=1.5", "--set adhesion_factor = 1.5 is not allowed"),
    "no value": ("adhesion_factor=", "must be key=value"),
    "no key": ("=1", "must be key=value"),
    "no equals sign": ("adhesion_factor", "must be key=value"),
    "not TOML": ("adhesion_factor=[0", "a bracket is opened and not closed"),
    "two values": ("adhesion_factor=1\ndensity=2", "not a TOML value"),
    "word for a number": ("adhesion_factor=high", "adhesion_factor = 'high' is not allowed"),
    "empty list": ("adhesion_factor=[]", "must be a list of one value or more"),
}


@pytest.mark.parametrize("mistake", MALFORMED)
def test_a_malformed_study_is_one_line_and_nothing_written(
    mistake: str, tmp_path: Path, refusal: Refusal
) -> None:
    content, expected = MALFORMED[mistake]
    path = tmp_path / "study.toml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    line = refusal(["run", str(path), "--out", str(tmp_path / "out")])
    assert line.startswith(f"harness: {path}: ")
    assert expected in line
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("mistake", BAD_SETTINGS)
def test_a_malformed_setting_is_one_line_and_nothing_written(
    mistake: str, tmp_path: Path, refusal: Refusal
) -> None:
    setting, expected = BAD_SETTINGS[mistake]
    out = tmp_path / "out"
    line = refusal(["run", "mesh_size", "--set", setting, "--out", str(out)])
    assert expected in line
    assert not out.exists()


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("mesh_sizes", "no such study; did you mean 'mesh_size'?"),
        ("there/mesh_sizes.toml", "no such file; did you mean 'mesh_size'?"),
        ("folder.toml", "not a file"),
        ("x" * 5000, "name too long"),
        ("file.txt", "no such study"),
        ("./file.txt", "is called NAME.toml"),
        ("../x/./.toml", "no such file"),
        ("..toml", "is called NAME.toml"),
    ],
)
def test_a_study_that_cannot_be_found_is_one_line(
    name: str, expected: str, tmp_path: Path, refusal: Refusal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.toml").mkdir()
    for file in ("file.txt", "..toml"):
        (tmp_path / file).write_text(GOOD)
    assert expected in refusal(["run", name])
    assert not (tmp_path / "results").exists()


def test_path_tricks_in_names_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("..toml", ".toml", "-x.toml", "a b.toml", "..\\x.toml", "a\nb.toml", "$(x).toml"):
        (tmp_path / name).write_text(GOOD)
        assert main(["run", str(tmp_path / name), "--out", "out"]) == 2, name
        assert len(capsys.readouterr().err.splitlines()) == 1, name
    for name in ("..", "../..", "/", "", "\0", "x" * 5000, "a/" * 3000 + "x.toml"):
        assert main(["run", name, "--out", "out"]) == 2, name
        assert len(capsys.readouterr().err.splitlines()) == 1, name
    assert not (tmp_path / "out").exists()


CONE = 'title = "t"\nscene = "cone_penetration"\n[compare]\n'
POINT = CONE.replace("cone_penetration", "material_point")
BOTH = CONE.replace('"cone_penetration"', '["material_point", "cone_penetration"]')

REFUSED = {
    "result misspelt": (
        CONE + "tolerance = { cone_facto = 0.1 }",
        "cone_facto = 0.1: is neither a reference nor a result; did you mean 'cone_factor'?",
    ),
    "error misspelt": (CONE + "tolerance = { eror = 0.1 }", "did you mean 'error'?"),
    "reference misspelt": (
        CONE + 'references = ["lu_2004"]\ntolerance = { lu_2005 = 0.1 }',
        "did you mean 'lu_2004'?",
    ),
    "result of a check misspelt": (
        POINT.replace("material_point", "flying_block") + "tolerance = { momentum_eror = 0.1 }",
        "did you mean 'momentum_error'?",
    ),
    "experience misspelt": (
        CONE + 'experience = ["karlsrud_2006"]',
        "unknown band of experience 'karlsrud_2006'; did you mean 'karlsrud_2005'?",
    ),
    "experience twice": (
        CONE + 'experience = ["karlsrud_2005", "karlsrud_2005"]',
        "names a band of experience twice",
    ),
    "experience of no cone": (
        POINT + 'experience = ["karlsrud_2005"]',
        "no scene here gives a cone_factor, which they are of",
    ),
    "tolerance of a band": (
        CONE + 'experience = ["karlsrud_2005"]\ntolerance = { karlsrud_2005 = 0.1 }',
        "is a band of experience, from which no result deviates",
    ),
    "references of a footing": (
        POINT.replace("material_point", "strip_footing") + 'references = ["lu_2004"]',
        "no scene here gives a cone_factor, which they are of",
    ),
    "reference study misspelt": (
        CONE + 'reference_study = "work_precision_referense"',
        "no such study; did you mean 'work_precision_reference'?",
    ),
    "reference study without a result": (
        CONE + 'reference_study = "mesh_size"',
        "mesh_size.nc is missing: run that study, and put it there",
    ),
    "reference study of no cone": (
        POINT + 'reference_study = "work_precision_reference"',
        "needs one scene, which gives a cone_factor",
    ),
    "reference study of two scenes": (
        BOTH + 'reference_study = "work_precision_reference"',
        "needs one scene, which gives a cone_factor",
    ),
    "references of no cone": (
        POINT + 'references = ["lu_2004"]',
        "no scene here gives a cone_factor, which they are of",
    ),
}


@pytest.mark.parametrize("mistake", REFUSED)
def test_what_cannot_be_compared_is_refused_before_the_run(
    mistake: str, tmp_path: Path, refusal: Refusal
) -> None:
    text, told = REFUSED[mistake]
    path = tmp_path / "s.toml"
    path.write_text(text)
    assert refusal(["run", str(path), "--out", str(tmp_path / "out")]).endswith(told)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    "text",
    [
        BOTH + 'references = ["lu_2004"]\ntolerance = { lu_2004 = 0.1 }',
        CONE + "tolerance = { cone_factor_variation = 0.01, cone_factor_shear = 1 }",
        CONE + "tolerance = { error = 0.1, error_finest = 0.1, run_time = 1 }",
        POINT + "tolerance = { error = 0.1, stress_exact = 1 }",
        POINT + "references = []",
        CONE + 'experience = ["karlsrud_2005", "mayne_peuchen_2018"]',
    ],
)
def test_results_that_only_a_run_can_tell_of_are_accepted(tmp_path: Path, text: str) -> None:
    path = tmp_path / "s.toml"
    path.write_text(text)
    assert load_study(str(path))
