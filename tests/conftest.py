"""What all tests have in common: how deep the hostile ones go, and signal handlers put back."""

import signal
from collections.abc import Callable, Iterator

import pytest
from hypothesis import HealthCheck, settings


def pytest_addoption(parser: pytest.Parser) -> None:
    """The option that makes the hostile tests try thousands of cases."""
    parser.addoption(
        "--deep",
        action="store_true",
        help="thousands of damaged files, malformed studies and random cases, not some fifty",
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
