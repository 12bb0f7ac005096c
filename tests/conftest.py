"""What all tests have in common: how deep the hostile ones go, processes, and pages."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
"""Threads of NumPy that wait for one another would take the cores from the processes of `-n`."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """The option that makes the hostile tests try thousands of cases, and compares all figures."""
    parser.addoption(
        "--deep",
        action="store_true",
        help="thousands of hostile cases, not some fifty, and all figures of the pages",
    )


def pytest_configure(config: pytest.Config) -> None:
    """The same few examples of Hypothesis each time, or many others."""
    settings.register_profile(
        "few",
        max_examples=50,
        derandomize=True,
        database=None,
        deadline=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    )
    settings.register_profile(
        "deep", settings.get_profile("few"), max_examples=10_000, derandomize=False
    )
    settings.load_profile("deep" if config.getoption("deep") else "few")


@pytest.fixture(scope="session")
def depth(pytestconfig: pytest.Config) -> Callable[[int, int], int]:
    """Chooses between the number of cases by default and that with ``--deep``."""
    return lambda few, many: many if pytestconfig.getoption("deep") else few


@pytest.fixture(autouse=True)
def signal_handlers_are_put_back() -> Iterator[None]:
    """A command that runs in this process sets its own; the next test begins without them."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE)
    before = [signal.getsignal(number) for number in numbers]
    yield
    for number, handler in zip(numbers, before, strict=True):
        signal.signal(number, handler)


LIMIT = 600  # a machine under load takes its time
"""Seconds after which what is waited for does not come."""


def wait_until(condition: Callable[[], bool]) -> None:
    """Wait until something holds, which must be soon."""
    deadline = time.monotonic() + LIMIT
    while not condition():
        assert time.monotonic() < deadline, "it never came"
        time.sleep(0.01)


def finished(command: Sequence[str], **given: Any) -> subprocess.CompletedProcess[str]:
    """A process of its own that has ended, however it did, and what it has said."""
    return subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=600, **given
    )


def blocks(page: str, language: str = "python") -> list[str]:
    """What a page has in a language, as a reader would copy it."""
    return re.findall(rf"^```{language}\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)


def said_by_commands(commands: str, folder: Path) -> str:
    """What commands of a page say in a folder, by the program and the Python of these tests."""
    program = (
        f'set -eo pipefail; harness() {{ "{sys.executable}" -m harness "$@"; }}\n'
        f'python() {{ "{sys.executable}" "$@"; }}\n{commands}'
    )
    root = {"PYTHONPATH": str(Path(__file__).parents[1])}
    done = finished(["bash", "-c", program], cwd=folder, env=os.environ | root)
    assert done.returncode == 0, done.stderr
    return done.stdout
