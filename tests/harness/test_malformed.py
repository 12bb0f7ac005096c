"""Studies, grounds, sites and command lines that are wrong: each is done or refused in one line.

Hypothesis makes studies and command lines that nobody would write, the same ones every time; with
``--deep`` many, others every time. A mutant is a sound file in which one to three places are
changed: a number, a word, a character, a line, a piece. Each is given to the command that reads
such a file.
"""

import contextlib
import json
import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cli.commands import interpret as command
from harness.cli.help import HELP
from harness.references.registry import REFERENCES
from harness.study.designs import DESIGNS, SPACINGS
from harness.study.files import studies_folder
from mpm_warp.fields.flat import parameters_of
from mpm_warp.scenes import scene_class, scene_names
from tests.harness.conftest import Depth, answered
from tests.harness.interpret.conftest import LAYER, SITE, write_site
from tests.harness.interpret.written_tests import WRITERS, rows_of

pytestmark = pytest.mark.slow

SCENES = ["cone_penetration", "sliding_block", "material_point"]
PARAMETERS = sorted({name for scene in SCENES for name in parameters_of(scene_class(scene))})

words = st.text(max_size=30) | st.sampled_from([*scene_names(), *PARAMETERS])
numbers = st.integers() | st.integers(-2, 60) | st.floats() | st.floats(-1, 100)
scalars = st.booleans() | numbers | words
expressions = st.lists(
    st.sampled_from([*PARAMETERS[:6], "1", "2.5", "+", "**", "<", "and", "(", ")", "sqrt(", "'a'"]),
    max_size=8,
).map(" ".join)
parameters = st.sampled_from(PARAMETERS) | words
ranges = st.fixed_dictionaries(
    {},
    optional={
        "from": scalars,
        "to": scalars,
        "count": st.integers(-1, 5) | scalars,
        "spacing": st.sampled_from(SPACINGS) | words,
    },
)
nested = st.recursive(scalars, lambda of: st.lists(of, max_size=3) | st.dictionaries(words, of))
tables = {
    "fixed": st.dictionaries(parameters, scalars, max_size=4),
    "vary": st.dictionaries(parameters, st.lists(scalars, max_size=3) | ranges, max_size=3),
    "derived": st.dictionaries(parameters, expressions, max_size=2),
    "compare": st.fixed_dictionaries(
        {},
        optional={
            "references": st.lists(st.sampled_from([*REFERENCES]) | words, max_size=3),
            "tolerance": st.dictionaries(words, scalars, max_size=2),
        },
    ),
    "timing": st.dictionaries(st.just("repeats") | words, scalars, max_size=1),
    "scenes": st.dictionaries(words, st.dictionaries(words, nested, max_size=2), max_size=2),
}
studies = st.fixed_dictionaries(
    {
        "title": st.just("t") | words,
        "scene": st.sampled_from(SCENES) | words | st.lists(st.sampled_from(SCENES), max_size=2),
    },
    optional={name: table | nested for name, table in tables.items()}
    | {
        "design": st.sampled_from(list(DESIGNS)) | words,
        "samples": st.integers(-1, 9) | scalars,
        "seed": scalars,
        "exclude": st.lists(expressions, max_size=3),
        "case": st.lists(tables["fixed"], max_size=3),
        "base": words,
    },
)


def toml(value: Any) -> str:
    """A value as TOML has it; texts as JSON, whose escapes TOML knows."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml(str(key))} = {toml(it)}" for key, it in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return str(value).lower() if isinstance(value, bool) else repr(value)


def check(arguments: list[str]) -> None:
    """Run a command, which is done or refused in one line."""
    code, told = answered(arguments)
    assert code < 2 or told.count("\n") == 1


@given(study=studies)
def test_any_study_is_read_or_refused_in_one_line(study: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text("".join(f"{key} = {toml(value)}\n" for key, value in study.items()))
    check(["status", str(path), "--out", str(tmp_path / "out")])
    assert not (tmp_path / "out").exists()


@given(
    command=st.sampled_from([it for it in HELP if it not in ("bench", "verify")]) | words,
    rest=st.lists(
        words.filter(lambda word: word not in scene_names())
        | st.sampled_from(
            [
                *("--out", "--set", "--workers", "--threads", "--tolerance", "--error", "--help"),
                *("--yes", "--memory-limit", "-o", "penetration=1", "a=[", "=", "8GB"),
                *("no.nc", "no.toml", "page.html", "1%"),
            ]
        ),
        max_size=5,
    ),
)
def test_any_command_line_is_done_or_refused(command: str, rest: list[str], tmp_path: Path) -> None:
    with contextlib.chdir(tmp_path):
        check([command, *rest])


NUMBERS = (
    *("0", "-1", "1", "1e-300", "1e9", "1e300", "1e400", "-1e400", "nan", "inf", "9" * 5000),
    *("true", '""', "'text'", "[]", "[1, 2]", "{}", "{ from = 1, to = 2 }", "1979-05-27", ""),
)
"""What may stand in the place of a number."""
CHARACTERS = ("", "\0", "\x1b[2J", *"\r\n\t\"',;.=[]{#")
"""What may stand in the place of a character."""
MORE = ("\u00e9", "\u202e", "\ufeff", "\U0001f600", "\ud7ff", "-", "e", "0")
"""And may be no ASCII."""

Mutation = Callable[[random.Random, str], str]


def in_place(pattern: str, others: Callable[[random.Random, str], str]) -> Mutation:
    """A mutation of one of the places that a pattern finds."""

    def mutated(source: random.Random, text: str) -> str:
        places = list(re.finditer(pattern, text))
        if not places:
            return text
        place = source.choice(places)
        return text[: place.start()] + others(source, place[0]) + text[place.end() :]

    return mutated


def other_word(source: random.Random, text: str) -> str:
    """A word of the text in the place of another."""
    words = re.findall(r"[A-Za-z_]\w*", text)
    return in_place(r"[A-Za-z_]\w*", lambda it, _: it.choice(words))(source, text)


def other_lines(source: random.Random, text: str) -> str:
    """A line is gone, is there twice, or stands elsewhere."""
    lines = text.splitlines(keepends=True)
    if not lines:
        return text
    line = lines.pop(source.randrange(len(lines)))
    for _ in range(source.choice((0, 1, 2, 2))):
        lines.insert(source.randint(0, len(lines)), line)
    return "".join(lines)


def cut(source: random.Random, text: str) -> str:
    """A piece is gone: the end, the beginning or one between."""
    first, second = sorted(source.randint(0, len(text)) for _ in range(2))
    return source.choice((text[:first], text[second:], text[:first] + text[second:]))


def repeated(source: random.Random, text: str) -> str:
    """A piece is there many times."""
    first = source.randint(0, len(text))
    piece = text[first : first + source.randint(1, 40)]
    return text[:first] + piece * source.choice((2, 100, 5000)) + text[first:]


MUTATIONS: tuple[Mutation, ...] = (
    in_place(r"-?\d[\d.e+-]*", lambda source, _: source.choice(NUMBERS)),
    in_place(r"-?\d[\d.e+-]*", lambda source, old: old + source.choice(("e9", "e-9", "0", ".5"))),
    in_place(r"(?s).", lambda source, _: source.choice(CHARACTERS + MORE)),
    in_place(r"(?s).", lambda source, old: old + source.choice(CHARACTERS + MORE)),
    in_place(r"\"[^\"\n]*\"", lambda source, _: f'"{source.choice(MORE) * 30}"'),
    other_word,
    other_lines,
    cut,
    repeated,
)


def mutant(source: random.Random, text: str) -> str:
    """A text with one to three mutations."""
    for _ in range(source.randint(1, 3)):
        text = source.choice(MUTATIONS)(source, text)
    return text


def test_a_mutant_of_a_study_is_read_or_refused_in_one_line(tmp_path: Path, depth: Depth) -> None:
    files = sorted(studies_folder().glob("*.toml"))
    texts = [it.read_text() for it in files]
    path, out = tmp_path / "mutant.toml", str(tmp_path / "out")
    commands = (["status", str(path), "--out", out], ["describe", str(path)], ["plan", str(path)])
    source = random.Random("studies")
    for number in range(depth(30, 2000)):
        path.write_text(mutant(source, source.choice(texts)), newline="")
        answered(commands[number % len(commands)])
    assert not Path(out).exists()


GROUND = """depth [m],strength [kPa],rigidity_index [1],unit_weight [kN/m3]
# a crust, soft clay, a stiff layer
0,50,100,18
1.5,50,100,18
3,12,120,16
13,32,120,16
13,80,150,19
20,90,150,19
"""
SOUNDING = 'title = "t"\nscene = "sounding"\n[fixed]\nfrom_depth = 1\nto_depth = 18\n'


def test_a_mutant_of_a_profile_is_read_or_refused_in_one_line(tmp_path: Path, depth: Depth) -> None:
    study, ground = tmp_path / "ground.toml", tmp_path / "ground.csv"
    study.write_text(SOUNDING + '[profile]\nfile = "ground.csv"\n')
    source = random.Random("profiles")
    for _ in range(depth(20, 500)):
        ground.write_text(mutant(source, GROUND), newline="")
        answered(["plan", str(study)])


def test_a_mutant_of_a_site_file_or_of_its_test_is_interpreted_or_refused_in_one_line(
    tmp_path: Path, depth: Depth, monkeypatch: pytest.MonkeyPatch
) -> None:
    if depth(1, 0):  # pictures of those that are sound take the most of a second each
        monkeypatch.setattr(command, "write_figure", lambda *_: [])
        monkeypatch.setattr(command, "write_own", lambda *_: None)
    rows = rows_of(write_site(tmp_path))
    tests = {kind: write(rows) for kind, write in WRITERS.items()}
    sites = {kind: (SITE + LAYER).replace("test.csv", f"test.{kind}") for kind in tests}

    source, file = random.Random("sites and tests"), tmp_path / "site.toml"
    for _ in range(depth(20, 500)):
        kind = source.choice(list(tests))
        site, test = sites[kind], tests[kind]
        for texts in ((mutant(source, site), test), (site, mutant(source, test))):
            for path, text in zip((file, tmp_path / f"test.{kind}"), texts, strict=True):
                path.write_text(text, newline="")
            answered(["interpret", str(file), "--out", str(tmp_path / "out")])
