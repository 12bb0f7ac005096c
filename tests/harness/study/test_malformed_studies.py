"""Many malformed study files, made with a seed: each is refused in one line, nothing is written.

Every file begins as a valid study and is broken in one way; that the valid one is accepted is
tested too, so that no file is refused for another reason.
"""

from __future__ import annotations

import contextlib
import io
import random
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from harness.cli.main import main
from harness.study.study import load_study
from mpm_warp.parameters import parameters_of
from mpm_warp.scenes.cone.cone_penetration import ConePenetration

KNOWN = list(parameters_of(ConePenetration).values())
NUMBERS = [it for it in KNOWN if it.kind is not str]
HEAD = 'title = "t"\nscene = "cone_penetration"\n'
LETTERS = "abzÄß\u4e2d\u202e\u0301\U0001f600 .-/\\'\u00a0\ufeff"
WRONG = ("true", '"1"', "[1]", "{a = 1}", "inf", "-inf", "nan", "1e308", "2026-01-01", "[[]]")
Broken = str | bytes
Breaker = Callable[[random.Random], Broken]


def _text(source: random.Random) -> str:
    return "".join(source.choices(LETTERS, k=source.randint(1, 30)))


def _basic(text: str) -> str:
    """A TOML text of `text`."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def wrong_type(source: random.Random) -> Broken:
    return HEAD + f"[fixed]\n{source.choice(NUMBERS).name} = {source.choice(WRONG)}"


def wrong_key(source: random.Random) -> Broken:
    table = source.choice(["", "[fixed]\n", "[vary]\n", "[derived]\n", "[compare]\n", "[timing]\n"])
    return HEAD + table + f"{_basic(_text(source))} = 1"


def wrong_design(source: random.Random) -> Broken:
    return source.choice(
        [
            f"design = {_basic(_text(source))}\n{HEAD}",
            f"design = {source.choice(WRONG)}\n{HEAD}",
            f"seed = {source.randint(0, 9)}\n{HEAD}",
            f'design = "latin_hypercube"\nsamples = {source.choice(["-1", "0", "1e3", "true"])}\n'
            + HEAD,
            f'design = "list"\ncase = {source.choice(WRONG[:3])}\n{HEAD}',
            HEAD + "[[case]]\ndensity = 1",
        ]
    )


def wrong_expression(source: random.Random) -> Broken:
    texts = [
        "__import__('os').mkdir('x')",
        "open('harness-was-here', 'w')",
        "(" * source.randint(1, 5000),
        "9**" * source.randint(3, 60) + "9",
        "density.real",
        _text(source) + "(",
        "1/0*density",
    ]
    text = _basic(source.choice(texts))
    return HEAD + source.choice([f"exclude = [{text}]", f"[derived]\nin_situ_stress = {text}"])


def wrong_base(source: random.Random) -> Broken:
    paths = ["../../etc/passwd", "/etc/passwd", "..", ".", "/", "/dev/zero", "study.toml", "\0", ""]
    paths += ["a/" * 3000, "x" * 3000 + ".toml", "~/.toml", _text(source), "../" * 40 + "etc/hosts"]
    path = source.choice(paths).replace("\0", "")
    return f"base = {_basic(path)}\n{HEAD}"


def wrong_scene(source: random.Random) -> Broken:
    names = [_basic(_text(source)), '"../cone_penetration"', '"os"', '"base"', '"__init__"', "[]"]
    names += ["1", "[1]", '["cone_penetration", "cone_penetration"]', '"cone_penetration.x"']
    return f'title = "t"\nscene = {source.choice(names)}'


def nested(source: random.Random) -> Broken:
    depth = source.choice([3, 50, 900, 5000, 50000])
    value = source.choice(["[" * depth + "]" * depth, "{a=" * depth + "1" + "}" * depth])
    return HEAD + f"[{source.choice(['fixed', 'vary'])}]\ndensity = {value}"


def dotted(source: random.Random) -> Broken:
    return HEAD + "fixed.density" + ".a" * source.randint(1, 3000) + " = 1"


def long_numbers(source: random.Random) -> Broken:
    digits = source.randint(400, 40_000)
    number = source.choice(["1" * digits, "0x" + "f" * digits, "-" + "9" * digits, "1e" + "9" * 99])
    return HEAD + f"[fixed]\ndensity = {number}"


def noise(source: random.Random) -> Broken:
    return HEAD.encode() + b"\xff" + source.randbytes(source.randint(1, 3000))


def truncated(source: random.Random) -> Broken:
    whole = HEAD + '[vary]\ndensity = [1, 2]\nmaterial = ["tresca"'
    return whole[: -source.randint(1, 4)]


BREAKERS: tuple[Breaker, ...] = (
    wrong_type,
    wrong_key,
    wrong_design,
    wrong_expression,
    wrong_base,
    wrong_scene,
    nested,
    dotted,
    long_numbers,
    noise,
    truncated,
)


def malformed(count: int) -> Iterator[tuple[str, bytes]]:
    """How `count` files are broken, and their content."""
    source = random.Random(1)
    for number in range(count):
        breaker = BREAKERS[number % len(BREAKERS)]
        content = breaker(source)
        yield breaker.__name__, content if isinstance(content, bytes) else content.encode()


def outcome_of_run(path: Path) -> tuple[object, str, str]:
    """Exit code and output of a run; an exception in place of the code is a traceback."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code: object = main(["run", str(path), "--out", str(path.parent / "out")])
        except BaseException as error:  # whatever it is, it is a failure
            code = error
    return code, out.getvalue(), err.getvalue()


def test_the_study_that_is_broken_is_a_valid_one(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(HEAD)
    assert len(load_study(str(path)).cases) == 1


def test_malformed_files_are_refused_in_a_line_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, depth: Callable[[int, int], int]
) -> None:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "study.toml"
    for number, (how, content) in enumerate(malformed(depth(3, 250) * len(BREAKERS))):
        path.write_bytes(content)
        code, out, err = outcome_of_run(path)
        what = f"file {number}, {how}: {content[:300]!r}: {code!r}: {err!r}"
        assert code == 2, what
        assert out == "", what
        assert err.endswith("\n"), what
        assert err.count("\n") == 1, what
        assert err[:-1].isprintable(), what
        assert err.startswith(f"harness: {path}:"), what
        assert list(tmp_path.iterdir()) == [path], what


def test_path_tricks_in_names_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("..toml", ".toml", "-x.toml", "a b.toml", "..\\x.toml", "a\nb.toml", "$(x).toml"):
        (tmp_path / name).write_text(HEAD)
        assert main(["run", str(tmp_path / name), "--out", "out"]) == 2, name
        assert len(capsys.readouterr().err.splitlines()) == 1, name
    for name in ("..", "../..", "/", "", "\0", "x" * 5000, "a/" * 3000 + "x.toml"):
        assert main(["run", name, "--out", "out"]) == 2, name
        assert len(capsys.readouterr().err.splitlines()) == 1, name
    assert not (tmp_path / "out").exists()
