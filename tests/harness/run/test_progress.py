import io
import re
import time

import pytest

from harness.archive.case_files import Outcome
from harness.run.run_study import Display
from harness.study.study import Study

pytestmark = pytest.mark.slow


class Terminal(io.StringIO):
    encoding = "utf-8"

    def isatty(self) -> bool:
        return True


def test_elsewhere_than_on_a_terminal_there_is_a_line_a_case(small: Study) -> None:
    case = small.cases[1]
    stream = io.StringIO()
    with Display(3, stream) as display:
        display.advanced(case, 0.5)
        display.finished(case, Outcome("failed", "why", "", 1.25))
    assert stream.getvalue() == "[1/3] adhesion_factor=0.5: failed, why, 1.2 s\n"


def test_the_bar_shows_cases_done_running_and_time_left(
    small: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: clock[0])
    stream = Terminal()
    with Display(4, stream) as display:
        first, second, third = small.cases
        display.finished(first, Outcome("completed"))
        display.advanced(second, 0.75)
        clock[0] += 60  # half of four cases are done after a minute
        display.advanced(third, 0.25)
    shown = stream.getvalue().split("\r")
    line = "1/4 cases, 2 running, at 50%, after 01:00, 01:00 left"
    bar = "█" * 12 + " " * 12
    assert any(it.startswith(f"{bar} {line}") for it in shown)


def test_the_bar_moves_on_where_the_clock_of_the_machine_is_set_back(
    small: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    now, clock = time.time(), [100.0]
    monkeypatch.setattr("tqdm.std.time", lambda: now - 86400.0)
    monkeypatch.setattr("time.monotonic", lambda: clock[0])
    stream = Terminal()
    with Display(2, stream) as display:
        clock[0] += 60
        display.advanced(small.cases[0], 0.5)
        assert "1 running, at 50%, after 01:00, 03:00 left" in stream.getvalue()


def test_a_case_is_being_set_up_until_it_computes_and_the_line_is_left_clean(small: Study) -> None:
    stream = Terminal()
    with Display(3, stream) as display:
        display.advanced(small.cases[0], 0.0)
        display.bar.refresh()
        assert "0/3 cases, 1 setting up, after" in stream.getvalue()
    assert re.search(r"\r +\r$", stream.getvalue())


def test_lines_of_cases_stand_above_the_bar(small: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    stream = Terminal()
    with Display(3, stream) as display:
        display.finished(small.cases[0], Outcome("completed", seconds=2.0))
        assert "\r[1/3] adhesion_factor=0.0: completed, 2.0 s\n" in stream.getvalue()
        assert "1/3 cases" in stream.getvalue().rpartition("\n")[2]


def test_times_to_start_and_to_compile_are_told_apart(small: Study) -> None:
    stream = io.StringIO()
    outcome = Outcome("completed", seconds=9.0, start_seconds=2.0, compile_seconds=4.5)
    with Display(1, stream) as display:
        display.finished(small.cases[0], outcome)
    assert stream.getvalue().endswith("completed, 2.5 s (2.0 s to start, 4.5 s to compile)\n")


@pytest.mark.parametrize(
    ("status", "environment", "told"),
    [
        ("completed", {"TERM": "xterm"}, "\033[32mcompleted\033[0m"),
        ("diverged", {"TERM": "xterm"}, "\033[31mdiverged\033[0m"),
        ("completed", {"TERM": "xterm", "NO_COLOR": "1"}, ": completed"),
        ("completed", {"TERM": "dumb"}, ": completed"),
    ],
)
def test_a_terminal_has_the_status_in_colour_where_that_is_wanted(
    status: str,
    environment: dict[str, str],
    told: str,
    small: Study,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    stream = Terminal()
    with Display(1, stream) as display:
        display.finished(small.cases[0], Outcome(status))
    assert told in stream.getvalue()
    assert ("\033[3" in stream.getvalue()) == ("\033[3" in told)
