"""Deliberate errors, `tests/mutations.toml`, and for each the test that is to notice it.

``python tests/mutations.py`` puts each error into a copy of the tree, runs its test alone, and
writes the table `tests/mutations.md`. ``python tests/mutations.py WORD ...`` tries only those whose
meaning has one of the words in it, and writes nothing.

An error is noticed where the test fails: not where it passes, cannot be collected or set up, or
takes too long. Without an error all of these tests have to pass. The exit code is 1 where an error
goes unnoticed. One whose text is not in its file, or more than once, is to be rewritten.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
TABLE = ROOT / "tests" / "mutations.md"
COPIED = ("harness", "mpm_warp", "studies", "tests", "pyproject.toml")
TIME_LIMIT = 300.0
"""Time that a test may take with an error in place [s]: many times what any takes without."""
PASSED, FAILED = "passed", "failed"


@dataclass(frozen=True)
class Mutation:
    """One deliberate error: in a file, a text that is replaced; and the test that notices it.

    Attributes:
        meaning: what is wrong.
        file: that it is in.
        right: text of the file, which is there once.
        wrong: what stands there instead.
        test: by pytest's name for it.
    """

    meaning: str
    file: str
    right: str
    wrong: str
    test: str

    def apply(self, tree: Path) -> None:
        """Put the error into a tree."""
        file = tree / self.file
        text = file.read_text()
        if text.count(self.right) != 1:
            raise SystemExit(f"{self.meaning}: {self.right!r} is not once in {self.file}")
        file.write_text(text.replace(self.right, self.wrong))


MUTATIONS = tuple(
    Mutation(**entry)
    for entry in tomllib.loads((ROOT / "tests" / "mutations.toml").read_text())["mutation"]
)


def outcome(tree: Path, nodes: Iterable[str], time_limit: float | None) -> tuple[str, str]:
    """What becomes of tests in a tree: `PASSED`, `FAILED` or in other words what else; and why."""
    with subprocess.Popen(
        [sys.executable, "-m", "pytest", "-q", "--tb=no", "-rfE", *nodes],
        cwd=tree,
        env=os.environ
        | {"PYTHONPATH": str(tree), "WARP_CACHE_PATH": str(tree.parent / "cache")}
        | {"COLUMNS": "200"},  # else there is no room for reasons
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    ) as pytest:
        try:
            told, _ = pytest.communicate(timeout=time_limit)
        except BaseException as error:
            os.killpg(pytest.pid, signal.SIGKILL)
            if isinstance(error, subprocess.TimeoutExpired):
                return "timed out", ""
            raise
    reasons = [line for line in told.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    reason = reasons[0].partition(" - ")[2] if reasons else ""
    if pytest.returncode == 0:
        return PASSED, ""
    if pytest.returncode == 1 and all(line.startswith("FAILED ") for line in reasons):
        return FAILED, reason
    return f"ended with {pytest.returncode}", reason


def copied(folder: Path) -> Path:
    """A copy of the tree in a folder, new."""
    tree = folder / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    tree.mkdir()
    for name in COPIED:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tree / name)
    return tree


def main(words: list[str]) -> int:
    """Try every error, or those with one of the words; returns the exit code."""
    tried = [it for it in MUTATIONS if not words or any(word in it.meaning for word in words)]
    lines = [
        "# Deliberate errors and the test that notices each",
        "",
        "Written by `python tests/mutations.py`.",
        "",
        "| error | file | test |",
        "|---|---|---|",
    ]
    unnoticed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sound, _ = outcome(copied(folder), dict.fromkeys(it.test for it in tried), None)
        if sound != PASSED:
            raise SystemExit(f"without an error the tests {sound}")
        for mutation in tried:
            tree = copied(folder)
            mutation.apply(tree)
            said, reason = outcome(tree, [mutation.test], TIME_LIMIT)
            unnoticed += said != FAILED
            noticed = f"`{mutation.test}`" if said == FAILED else f"**unnoticed**: {said}"
            lines.append(f"| {mutation.meaning} | `{mutation.file}` | {noticed} |")
            print(lines[-1], reason, flush=True)
    if not words:
        TABLE.write_text("\n".join(lines) + "\n")
    return 1 if unnoticed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
