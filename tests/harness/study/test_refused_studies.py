"""Studies that are wrong: each is refused in one line that says what, and nothing is written."""

from pathlib import Path

import pytest

from mpm_warp.fields.flat import parameters_of
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from tests.harness.conftest import HEAD, Refusal, study_in

SCENE = 'scene = "cone_penetration"\n'
ALLOWED = {name: it.allowed for name, it in parameters_of(ConePenetration).items()}
MANY = list(range(1001, 2001))
OURS = '[references.it]\nformula = "Ir"\nlabel = "l"\nsource = "s"\n'


def points(columns: str) -> str:
    """That reference by points in place of its formula."""
    return OURS.replace('formula = "Ir"', f"points = {{ {columns} }}")


OWN_TABLE = "[scenes.cone_penetration.vary]\nrigidity_index = [50, 60]\n"
DRAWN = 'design = "latin_hypercube"\nsamples = 4\nseed = 1\n[vary]\n'

OF_A_CONE = [
    # Values.
    (
        "[fixed]\nadhesion_factr = 1",
        "[fixed] adhesion_factr = 1: unknown parameter 'adhesion_factr'; did you mean 'adhesion_",
    ),
    ("[fixed]\nadhesion_factor = 1.5", "adhesion_factor = 1.5 is not"),
    ("[fixed]\ndensity = 2026-01-01", f"must be {ALLOWED['density']}"),
    ("[fixed.density]\na = 1", f"must be {ALLOWED['density']}"),
    (f"[fixed]\ndensity = {2**80}", f"must be {ALLOWED['density']}"),
    ("[fixed]\ndensity = 0x" + "f" * 20000, "too long to show"),
    ("[vary]\nadhesion_factor = [0, 2]", "[vary] adhesion_factor = 2"),
    ("[vary]\ndensity = []", "must be a list of values"),
    ("[vary]\ndensity = [1, 2, 1.0]", "1.0 is listed twice"),
    (f"[vary]\ndensity = {[*range(1, 60_001), 60_000]}", "60000.0 is listed twice"),
    ("[vary]\ndensity = [[1]]", "[vary] density = [1] is not allowed: must be a number"),
    ("[fixed]\ndensity = 1\n[vary]\ndensity = [1]", "as well"),
    # Laws.
    (
        '[vary]\nmaterial = ["tresca", { law = "anisotropic" }]',
        "a list has names alone; vary what one of them has as material.its_parameter = [..]",
    ),
    (
        '[fixed]\n"material.swelling_slope" = 0.04\nmaterial = { swelling_slope = 0.03 }',
        "s.toml: [fixed] material.swelling_slope: is given twice; keep one of them",
    ),
    (
        '[scenes.cone_penetration.fixed]\nmaterial = "tresca"\n"material.law" = "von_mises"',
        "s.toml: [scenes] [cone_penetration] [fixed] material: is given twice",
    ),
    (
        'design = "list"\n[[case]]\n"material.law" = "tresca"\nmaterial = "tresca"',
        "s.toml: [[case]] 1: material: is given twice",
    ),
    (
        '[fixed]\nmaterial = { law = "modified_cm_clay", cohesion = 1 }',
        "material = 'modified_cm_clay' is not allowed: must be one of",
    ),
    (
        'design = "list"\n[[case]]\nmaterial = { law = "modified_cm_clay", cohesion = 1 }',
        "[[case]] 1: material = 'modified_cm_clay' is not allowed: must be one of",
    ),
    (
        '[fixed]\nmaterial = { law = "modified_cam_clay", swelling_slope = 1e300 }',
        "must be a number > 0, smaller than 1e+300; meaning",
    ),
    # Ranges.
    ("[vary]\nmaterial = { from = 1, to = 2 }", "unknown parameter 'material.from'"),
    (
        "[vary]\nadhesion_factor = { from = 0, to = 2, count = 3 }",
        "to = 2 is not allowed: must be a number >= 0 and <= 1",
    ),
    ("[vary]\ndensity = { from = [2], to = 3, count = 2 }", "from = [2] is not allowed: must be a"),
    ("[vary]\ndensity = { from = 1, count = 2 }", "to: is missing"),
    ("[vary]\ndensity = { from = 1, to = 2 }", "count: is missing"),
    (
        "[vary]\ndensity = { from = 1, to = 2, count = 10000000000 }",
        "count = 10000000000 is not allowed: must be an integer >= 2 and <= 100000",
    ),
    (
        '[vary]\nadhesion_factor = {from=0, to=1, count=3, spacing="logarithmic"}',
        "from and to must be > 0",
    ),
    (f"[vary]\ndensity = {MANY}\nundrained_shear_strength = {MANY}", "gives 1000000 cases"),
    # Expressions.
    ('[derived]\ndensity = "2 * densit"', "did you mean 'density'"),
    ('[derived]\ndensity = "2 * density"', "is derived too"),
    ('[derived]\nadhesion_factor = "rigidity_index"', "adhesion_factor = 100.0 is not allowed"),
    ('[fixed]\ndensity = 1\n[derived]\ndensity = "2"', "is under [fixed] as well"),
    (
        '[derived]\nadhesion_factor = "reference_strain_rate"',
        "reference_strain_rate has no value here, unless the study gives it one",
    ),
    ('[derived]\ndensity = "1e400"', "[derived] density: '1e400' has no value: it is inf"),
    ('exclude = ["density + 1"]', "exclude: 'density + 1' is 1701.0, neither true nor false"),
    (
        'exclude = ["1 / stress_anisotropy > 2"]',
        "exclude: '1 / stress_anisotropy > 2' has no value",
    ),
    ('exclude = ["density > 0"]', "removes every case"),
    ("exclude = [\"open('x')\"]", "unknown function 'open'"),
    (
        f"exclude = {101 * ['density > 1']}",
        "has 101 conditions; a study has at most 100; join them by `or`",
    ),
    # Designs and scenes.
    ('design = "ful"', "did you mean 'full'"),
    ("stability_map = 1", "stability_map = 1 is not allowed: must be true or false"),
    ("stability_map = true", 'one scene and design = "one_at_a_time" or "latin_hypercube"'),
    ("samples = 3", "latin_hypercube"),
    ('design = "latin_hypercube"\nseed = 1', "samples: is missing"),
    ('design = "latin_hypercube"\nsamples = 2\nseed = 1', "nothing to sample"),
    ("[vary]\ndensity = { low = 1, high = 2 }", 'needs design = "latin_hypercube"'),
    (DRAWN + "adhesion_factor = { low = 0, high = 2 }", "goes from 2e-06 to 2, must be >= 0"),
    (
        DRAWN + "particles_per_cell = { low = 4, high = 9 }",
        "cannot be a distribution; must be one of 4",
    ),
    ("[[case]]\ndensity = 1", 'is allowed only with design = "list"'),
    ('design = "list"', "[[case]]"),
    ('design = "list"\n[[case]]\ndensty = 1', "[[case]] 1: densty = 1"),
    ('design = "list"\n[[case]]\ndensity = [1]', "[[case]] 1: density = [1] is not allowed"),
    ("[scenes.material_point]", "unknown key"),
    ('[scenes.cone_penetration]\ntitle = "x"', "[scenes] [cone_penetration] title"),
    ("fixed.density = -1\n" + OWN_TABLE, "s.toml: [fixed] density = -1"),
    (OWN_TABLE + "density = [-1]", "s.toml: [scenes] [cone_penetration] [vary] density = -1"),
    # Keys.
    ("[varry]\ndensity = [1]", "unknown key; did you mean 'vary'?"),
    ("scenne = 1", "unknown key; did you mean 'scene'?"),
    ("vary = 1", "must be a table [vary]"),
    ("[timing]\nrepeats = 2.5", "repeats = 2.5 is not allowed: must be an integer"),
    ("[timing]\nrepeats = 0", "must be an integer >= 1 and <= 1000"),
    ("[timing]\nrepeat = 2", "did you mean 'repeats'?"),
    # TOML.
    (
        "[fixed]\ndensity = " + "1" * 5000,
        "s.toml: not valid TOML: an integer of more than 4300 digits at line 4",
    ),
    ("a" + ".a" * 300_000 + " = 1", "a dotted key has more than 20 parts"),
    ("fixed.density" + ".a" * 3000 + " = 1", "a dotted key has more than 20 parts"),
    ("[fixed\n", "not valid TOML: Expected"),
    ('title = "again"', "not valid TOML: Cannot overwrite"),
    (
        '[fixed]\nmaterial = "tresca"\nmaterial.swelling_slope = 0.03',
        'give both in one table: material = { law = "its_name", swelling_slope = 0.03 }',
    ),
    ('[fixed]\n"a\\nb" = 1', r"a\nb"),
    ("#" * 2_000_000, "a study has at most"),
    # What is compared.
    ("[compare]\nreference = []", "did you mean 'references'?"),
    ('[compare]\nreferences = ["lu_2005"]', "did you mean 'lu_2004'?"),
    ("[compare]\nreferences = [{}]", "unknown reference {}"),
    ('[compare]\nreferences = "lu_2004"', "must be a list"),
    ('[compare]\nreferences = ["lu_2004", "lu_2004"]', "names a reference twice"),
    (
        "[compare]\ntolerance = { cone_facto = 0.1 }",
        "cone_facto = 0.1: is neither a reference nor a result; did you mean 'cone_factor'?",
    ),
    ("[compare]\ntolerance = { eror = 0.1 }", "did you mean 'error'?"),
    ("[compare]\ntolerance = 0.1", "must be a table"),
    ("[compare]\ntolerance = { lu_2004 = 0.1 }", "is not among the references"),
    ("[compare]\ntolerance = { error = 0 }", "must be a number > 0"),
    ('[compare]\ntolerance = { error = "1" }', "must be a number > 0"),
    (
        '[compare]\nreferences = ["lu_2004"]\ntolerance = { lu_2005 = 0.1 }',
        "neither a reference nor a result; did you mean 'lu_2004'?",
    ),
    (
        '[compare]\nexperience = ["karlsrud_2006"]',
        "unknown band of experience 'karlsrud_2006'; did you mean 'karlsrud_2005'?",
    ),
    (
        '[compare]\nexperience = ["karlsrud_2005", "karlsrud_2005"]',
        "names a band of experience twice",
    ),
    (
        '[compare]\nexperience = ["karlsrud_2005"]\ntolerance = { karlsrud_2005 = 0.1 }',
        "is a band of experience; a tolerance needs a reference",
    ),
    (
        '[compare]\nreference_study = "work_precision_referense"',
        "no such study; did you mean 'work_precision_reference'?",
    ),
    (
        '[compare]\nreference_study = "mesh_size"',
        "mesh_size.nc is missing; run that study and copy its result there",
    ),
    # Snapshots.
    ("snapshots = 5", "snapshots = 5: must be a list of values, or a range"),
    ("snapshots = [0]", "snapshots = 0 is not allowed: must be a number > 0 and <= "),
    ("snapshots = [3000]", "snapshots = 3000 is not allowed: must be a number"),
    ("snapshots = [5, 5]", "snapshots = [5, 5]: 5.0 is listed twice"),
    ("snapshots = { from = 1, to = 4 }", "snapshots: count: is missing"),
    # References of its own.
    ('[references.it]\nlabel = "l"\nsource = "s"', "formula: is missing"),
    (OURS.replace('"Ir"', '"2 *"'), "is not an expression"),
    (
        OURS.replace('"Ir"', '"rigidity_indx"'),
        "unknown parameter or symbol 'rigidity_indx'; did you mean 'rigidity_index'?",
    ),
    (OURS.replace('"Ir"', '"Ir > 2"'), "must give a number"),
    (OURS + "labels = 1", "unknown key; did you mean 'label'?"),
    (OURS.replace(".it]", ".lu_2004]"), "a reference that ships has this name"),
    (OURS + "range = { It = [1, 2] }", "unknown parameter or symbol 'It'"),
    (OURS + "range = { Ir = [1] }", "must be two numbers"),
    (OURS + "range = { Ir = [2, 1] }", "must be two numbers, the least"),
    (OURS + 'criterion = "von mises"', "'von_mises', 'modified_cam_clay'; did you"),
    (OURS + 'su_mode = "compression"', "one of 'not_stated', 'pure_shear', 'triaxial_compression'"),
    (OURS + "points = { Ir = [1], Nc = [2] }", "formula says the value too"),
    (points("Ir = [1]"), "of one length: symbols, and Nc"),
    (points("Ir = [1, 2], Nc = [2]"), "must be columns of one length"),
    (points("Ir = [nan], Nc = [2]"), "a list of numbers"),
    (points("It = [1], Nc = [2]"), "unknown parameter or symbol 'It'"),
    (points("Ir = [50, 60, 50], Nc = [9, 10, 11]"), "has 2 values at Ir = 50; a place has one"),
    (points("Ir = [50, 60], Nc = [9, 0]"), "[points] Nc = [9, 0]: a cone factor must be > 0"),
    (OURS.replace('"Ir"', '"2 - 3"'), "formula = '2 - 3': is -1.0; a cone factor is a number > 0"),
    (OURS.replace('"Ir"', "\"'a'\""), "a cone factor is a number > 0"),
    (OURS.replace('"Ir"', '"sqrt(-1)"'), "'sqrt(-1)' has no value"),
    ("references = 3", "must be a table"),
    ('[references]\nlabel = "l"', "belongs to a reference, a table [references.its_name]"),
]
"""What a study of a cone says beside title and scene, and what the answer has in it."""

POINT = 'title = "t"\nscene = "material_point"\n[compare]\n'
BOTH = POINT.replace('"material_point"', '["material_point", "cone_penetration"]')
STUDY_OF_REFERENCE = 'reference_study = "work_precision_reference"'
OTHERS = [
    ("fixed = 1\n" + HEAD, "must be a table [fixed]"),
    ('title = "t"\nscene = "cone_penetratoin"', "did you mean 'cone_penetration'"),
    ('title = "t"\nscene = 1', "scene = 1 is not allowed: must be a text of one line"),
    ('title="t"\nscene = ["material_point", "material_point"]', "twice"),
    ('title = "t"', "scene: is missing; known: "),
    (SCENE, "title: is missing"),
    (SCENE + f'title = "{"a" * 900_000}"', "has 900000 characters; a text has at most 1000"),
    (SCENE + 'title = "a\\nb"', "must be a text of one line"),
    ('base = "s.toml"\n' + HEAD, "form a circle"),
    ('base = "adhesion_facto"\n', "did you mean 'adhesion_factor'"),
    ("base = 3\n", "must be a text"),
    ("", "is missing"),
    ("a = " + "[" * 20000, "nested too deeply"),
    (
        POINT.replace("material_point", "flying_block") + "tolerance = { momentum_eror = 0.1 }",
        "did you mean 'momentum_error'?",
    ),
    (POINT + 'experience = ["karlsrud_2005"]', "needs a scene that computes a cone_factor"),
    (POINT + 'references = ["lu_2004"]', "references = ['lu_2004']: needs a scene that computes"),
    (POINT + STUDY_OF_REFERENCE, "needs a single scene that computes a cone_factor"),
    (BOTH + STUDY_OF_REFERENCE, "reference': needs a single scene that computes a cone_factor"),
    (
        BOTH.replace("[compare]", "[fixed]\napex_angle = 60"),
        "s.toml: material_point: [fixed] apex_angle = 60: unknown parameter 'apex_angle'; known: ",
    ),
    (POINT + OURS.replace("Ir", "2"), "[references]: needs a scene that computes a cone_factor"),
]
SOUNDING = 'title = "t"\nscene = "sounding"\n'
COLUMNS = '[profile]\n"depth [m]" = [0, 8]\n"strength [kPa]" = [40, 60]\n'
OF_A_SOUNDING = [
    ('[profile]\nfile = "no.csv"', "file = 'no.csv': cannot be read: No such file"),
    ('[profile]\nfile = "ground.csv"\nx = 1', "x = 1: unknown key"),
    ('[profile]\nfile = "/etc/passwd"', "must be in the folder of the study, or below it"),
    ('[profile]\n"depth [m]" = 1', "depth [m] = 1: must be a list of numbers"),
    ('[profile]\n"depth [m]" = [0, 1]\n"strength [kPa]" = [1]', "have different lengths"),
    ('[profile]\n"depth [m]" = [0]\n"strength [kPa]" = [-1]', "strength in row 1 is -1000"),
    ("[profile]\n", "[profile]: header"),
    ("profile = 3", "profile = 3: must be a table [profile]"),
    (COLUMNS + '[fixed]\nprofile = "x"', "stands under [profile] as well"),
    (COLUMNS + "[fixed]\nto_depth = 9", "profile: ends at 8 m, must reach to_depth = 9 m"),
    ("snapshots = [1]", "sounding takes no snapshots"),
    # The message is shortened, because it lists all parameters.
    ("[fixed]\nzzz = 1", "s.toml: [fixed] zzz = 1: unknown parameter 'zzz'; known: "),
    ('exclude = ["zzz > 1"]', "s.toml: exclude = 'zzz > 1': unknown parameter 'zzz'; known: "),
]
MISTAKES = [(HEAD + text, told) for text, told in OF_A_CONE]
MISTAKES += [(SOUNDING + text, told) for text, told in OF_A_SOUNDING] + OTHERS


@pytest.mark.parametrize(("text", "told"), MISTAKES, ids=[told for _, told in MISTAKES])
def test_a_wrong_study_is_refused(text: str, told: str, tmp_path: Path, refusal: Refusal) -> None:
    path = tmp_path / "s.toml"
    path.write_text(text)
    line = refusal(["run", str(path), "--out", str(tmp_path / "out")])
    assert line.startswith(f"harness: {path}:")
    assert told in line
    # What is allowed does not lead to a table that the value cannot stand in.
    assert "[vary]" not in line.partition("not allowed")[2]
    assert list(tmp_path.iterdir()) == [path]


def test_bytes_that_are_no_text_are_told_by_their_place(tmp_path: Path, refusal: Refusal) -> None:
    path = tmp_path / "s.toml"
    path.write_bytes(b'title = "\xff"')
    assert refusal(["run", str(path)]) == f"harness: {path}: not UTF-8 at byte 9"


def test_path_tricks_in_names_are_refused(here: Path, refusal: Refusal) -> None:
    tricks = ("..toml", ".toml", "-x.toml", "a b.toml", "..\\x.toml", "a\nb.toml", "$(x).toml")
    for name in tricks:
        (here / name).write_text(HEAD)
        refusal(["run", str(here / name), "--out", "out"])
    for name in ("..", "../..", "/", "", "\0", "x" * 5000, "a/" * 3000 + "x.toml"):
        refusal(["run", name, "--out", "out"])
    assert not (here / "out").exists()


@pytest.mark.parametrize(
    "text",
    [
        BOTH + 'references = ["lu_2004"]\ntolerance = { lu_2004 = 0.1 }',
        HEAD + "[compare]\ntolerance = { cone_factor_variation = 0.01, cone_factor_shear = 1 }",
        HEAD + "[compare]\ntolerance = { error = 0.1, error_finest = 0.1, run_time = 1 }",
        POINT + "tolerance = { error = 0.1, stress_exact = 1 }",
        POINT + "references = []",
        HEAD + '[compare]\nexperience = ["karlsrud_2005", "mayne_peuchen_2018"]',
    ],
)
def test_results_that_only_a_run_can_tell_of_are_accepted(tmp_path: Path, text: str) -> None:
    assert study_in(tmp_path, text)
