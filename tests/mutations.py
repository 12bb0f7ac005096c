"""Deliberate errors, `tests/mutations.toml`, and for each the test that is to notice it.

``python tests/mutations.py`` puts each error into a copy of the tree and runs its test alone;
``python tests/mutations.py WORD ...`` tries those whose meaning has one of the words in it.

Two copies of the tree are at work at the same time. They share a cache of kernels, in which the
tests without an error leave theirs: with an error only the kernels that it changes are compiled.

An error is noticed where the test fails: not where it passes, cannot be collected or set up, or
takes too long. Without an error all of these tests have to pass. The exit code is 1 where an error
goes unnoticed. One whose text is not in its file, or more than once, is to be rewritten: all of
them are listed before anything is run.
"""

import compileall
import os
import py_compile
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

ROOT = Path(__file__).parent.parent
COPIED = ("harness", "mpm_warp", "studies", "tests", "pyproject.toml")
COPIES = 2
"""Copies of the tree in which errors are tried at the same time."""
TIME_LIMIT = 300.0
"""Time that a test may take with an error in place [s]: many times what any takes without."""
PASSED, FAILED = "passed", "failed"


@dataclass(frozen=True)
class Mutation:
    """One deliberate error: a text that is replaced in a file, and the test that notices it.

    Attributes:
        meaning: what is wrong.
        file: path of the file.
        right: the correct text, which the file has exactly once.
        wrong: the text that replaces it.
        test: pytest's name of the test.
    """

    meaning: str
    file: str
    right: str
    wrong: str
    test: str

    def fault(self) -> str:
        """Why the error cannot be tried in the tree as it is; "" where it can."""
        file, test = ROOT / self.file, ROOT / self.test.partition("::")[0]
        if not file.is_file() or not test.is_file():
            return f"no file {self.test if file.is_file() else self.file}"
        count = file.read_text().count(self.right)
        return "" if count == 1 else f"{count} times in {self.file}: {self.right!r}"


MUTATIONS = tuple(
    Mutation(**entry)
    for entry in tomllib.loads((ROOT / "tests" / "mutations.toml").read_text())["mutation"]
)


def outcome(tree: Path, arguments: Iterable[str], time_limit: float | None) -> tuple[str, str]:
    """Outcome of tests in a tree, `PASSED`, `FAILED` or another in words, and the reason."""
    settings = {
        "PYTHONPATH": str(tree),
        "WARP_CACHE_PATH": str(tree.parent / "cache"),
        "PYTHONDONTWRITEBYTECODE": "1",  # bytecode would outlive its error
        "COLUMNS": "200",  # wide enough for reasons
    }
    with subprocess.Popen(
        [sys.executable, "-m", "pytest", "-q", "--tb=no", "-rfE", *arguments],
        cwd=tree,
        env=os.environ | settings,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    ) as pytest:
        try:
            output, _ = pytest.communicate(timeout=time_limit)
        except BaseException as error:
            os.killpg(pytest.pid, signal.SIGKILL)
            if isinstance(error, subprocess.TimeoutExpired):
                return "timed out", ""
            raise
    reasons = [line for line in output.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    reason = reasons[0].partition(" - ")[2] if reasons else ""
    if pytest.returncode == 1 and all(line.startswith("FAILED ") for line in reasons):
        return FAILED, reason
    return f"ended with {pytest.returncode}" if pytest.returncode else PASSED, reason


def copied(tree: Path) -> Path:
    """A copy of the project whose bytecode is checked by the content of sources, not their age."""
    tree.mkdir()
    for name in COPIED:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tree / name)
    by_content = py_compile.PycInvalidationMode.CHECKED_HASH
    compileall.compile_dir(tree, quiet=1, force=True, invalidation_mode=by_content)
    return tree


def tried(mutations: list[Mutation]) -> int:
    """Try errors and print a line for each; returns the number that goes unnoticed."""
    nodes = dict.fromkeys(it.test for it in mutations)
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(COPIES) as pool:
        trees = SimpleQueue[Path]()
        for number in range(COPIES):
            trees.put(copied(Path(name, str(number))))
        sound, reason = outcome(Path(name, "0"), [f"-n{COPIES}", "--dist=worksteal", *nodes], None)
        if sound != PASSED:
            raise SystemExit(f"without an error the tests {sound}: {reason}")

        def attempt(mutation: Mutation) -> tuple[str, str, float]:
            tree, start = trees.get(), time.monotonic()
            file = tree / mutation.file
            text = file.read_text()
            file.write_text(text.replace(mutation.right, mutation.wrong))
            try:
                return *outcome(tree, [mutation.test], TIME_LIMIT), time.monotonic() - start
            finally:
                file.write_text(text)
                trees.put(tree)

        unnoticed = 0
        for mutation, (said, reason, seconds) in zip(
            mutations, pool.map(attempt, mutations), strict=True
        ):
            unnoticed += said != FAILED
            noticed = f"noticed by {mutation.test}" if said == FAILED else f"UNNOTICED: {said}"
            print(f"{seconds:.0f} s  {mutation.meaning}: {noticed}  {reason}", flush=True)
    return unnoticed


def main(words: list[str]) -> int:
    """Try every error, or those with one of the words; returns the exit code."""
    chosen = [it for it in MUTATIONS if not words or any(word in it.meaning for word in words)]
    if not chosen:
        raise SystemExit(f"no deliberate error has one of these words in its meaning: {words}")
    faults = [f"{it.meaning}: {fault}" for it in chosen if (fault := it.fault())]
    if faults:
        raise SystemExit("\n".join(faults))
    return 1 if tried(chosen) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
