"""Studies and command lines that nobody would write: each is done, or refused in one line.

Hypothesis makes them, the same ones every time; with ``--deep`` many, others every time.
"""

import contextlib
import io
import json
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cli.help import HELP
from harness.cli.main import main
from harness.errors import LONGEST_LINE
from harness.references.registry import REFERENCE_IDS
from harness.study.designs import DESIGNS, SPACINGS
from mpm_warp.parameters import parameters_of
from mpm_warp.scenes import scene_class, scene_names

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
            "references": st.lists(st.sampled_from(REFERENCE_IDS) | words, max_size=3),
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
    """Run a command: it ends with a code, and where that is 2 with one line."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main(arguments)
        except SystemExit as end:  # of the command line's own errors and of --help
            code = int(end.code or 0)
    assert code in (0, 1, 2)
    if code == 2:
        assert out.getvalue() == ""
        line = err.getvalue()
        assert line.endswith("\n")
        assert line[:-1].isprintable()
        assert len(line) < LONGEST_LINE + 100
        assert not any(name in line for name in ("Error:", "Exception", "Errno", "Traceback"))


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
                *("--yes", "--memory-limit", "--batch", "-o", "penetration=1", "a=[", "=", "8GB"),
                *("no.nc", "no.toml", "page.html", "1%"),
            ]
        ),
        max_size=5,
    ),
)
def test_any_command_line_is_done_or_refused_in_one_line(
    command: str, rest: list[str], tmp_path: Path
) -> None:
    before = Path.cwd()
    os.chdir(tmp_path)
    try:
        check([command, *rest])
    finally:
        os.chdir(before)
