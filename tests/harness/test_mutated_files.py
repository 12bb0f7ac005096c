"""Studies, grounds and site files with something wrong in them: read, or refused in one line.

A mutant is a sound file in which one to three places are changed: a number, a word, a character, a
line, a piece. Each is given to the command that reads such a file, which does it or says in one
line what is wrong. The slowest mutants are printed (``-s``).
"""

import contextlib
import io
import random
import re
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.cli.commands import interpret as command
from harness.cli.main import main
from harness.errors import LONGEST_LINE
from harness.study.files import studies_folder
from tests.harness.conftest import Depth
from tests.harness.interpret.conftest import LAYER, SITE, write_site
from tests.harness.interpret.test_files import WRITERS, rows_of

pytestmark = pytest.mark.slow

NUMBERS = (
    *("0", "-1", "1", "1e-300", "1e9", "1e300", "1e400", "-1e400", "nan", "inf", "9" * 5000),
    *("true", '""', "'text'", "[]", "[1, 2]", "{}", "{ from = 1, to = 2 }", "1979-05-27", ""),
)
"""What may stand in the place of a number."""
CHARACTERS = (
    "",
    "\0",
    "\x1b[2J",
    "\r",
    "\n",
    "\t",
    '"',
    "'",
    ",",
    ";",
    ".",
    "=",
    "[",
    "]",
    "{",
    "#",
)
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
    return (
        in_place(r"[A-Za-z_]\w*", lambda it, _: it.choice(words))(source, text) if words else text
    )


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


def seconds_of(arguments: list[str]) -> float:
    """How long a command takes, which is done or refused in one line."""
    out, err = io.StringIO(), io.StringIO()
    begin = time.perf_counter()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(arguments)
    seconds = time.perf_counter() - begin
    told = err.getvalue()
    assert code in (0, 1, 2), told
    assert all(it.isprintable() for it in (*out.getvalue(), *told) if it != "\n")
    assert not any(it in told for it in ("Error:", "Exception", "Errno", "Traceback")), told
    if code == 2:
        line = told.splitlines()[-1]
        assert len(line) < LONGEST_LINE + 100
        assert out.getvalue() == ""
    return seconds


def told_of_slowest(seconds: list[tuple[float, str]]) -> None:
    """The slowest of some mutants; a limit in the test would be one of the machine."""
    slowest, what = max(seconds)
    print(f"\n{len(seconds)} mutants, the slowest {slowest:.2f} s: {what}")


def test_a_mutant_of_a_study_is_read_or_refused_in_one_line(tmp_path: Path, depth: Depth) -> None:
    files = sorted(studies_folder().glob("*.toml"))
    texts = [it.read_text() for it in files]
    path, out = tmp_path / "mutant.toml", str(tmp_path / "out")
    commands = (["status", str(path), "--out", out], ["describe", str(path)], ["plan", str(path)])
    source, seconds = random.Random("studies"), []
    for number in range(depth(30, 2000)):
        path.write_text(mutant(source, source.choice(texts)), newline="")
        arguments = commands[number % len(commands)]
        seconds.append((seconds_of(arguments), f"{number} {arguments[0]}"))
    told_of_slowest(seconds)
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
    source, seconds = random.Random("profiles"), []
    for number in range(depth(20, 500)):
        ground.write_text(mutant(source, GROUND), newline="")
        seconds.append((seconds_of(["plan", str(study)]), str(number)))
    told_of_slowest(seconds)


def test_a_mutant_of_a_site_file_or_of_its_test_is_interpreted_or_refused_in_one_line(
    tmp_path: Path, depth: Depth, monkeypatch: pytest.MonkeyPatch
) -> None:
    if depth(1, 0):  # pictures of those that are sound take the most of a second each
        monkeypatch.setattr(command, "image", lambda *_: b"")
        monkeypatch.setattr(command, "write_own", lambda *_: None)
    rows, count, seconds = rows_of(write_site(tmp_path)), depth(20, 500), []
    tests = {kind: write(rows) for kind, write in WRITERS.items()}
    sites = {kind: (SITE + LAYER).replace("test.csv", f"test.{kind}") for kind in tests}

    def interpreted(what: str, kind: str, site: str, test: str) -> None:
        (tmp_path / "site.toml").write_text(site, newline="")
        (tmp_path / f"test.{kind}").write_text(test, newline="")
        arguments = ["interpret", str(tmp_path / "site.toml"), "--out", str(tmp_path / "out")]
        seconds.append((seconds_of(arguments), f"{what} {kind}"))

    source = random.Random("sites and tests")
    for number in range(count):
        kind = source.choice(list(tests))
        interpreted(f"site {number}", kind, mutant(source, sites[kind]), tests[kind])
        interpreted(f"test {number}", kind, sites[kind], mutant(source, tests[kind]))
    told_of_slowest(seconds)
