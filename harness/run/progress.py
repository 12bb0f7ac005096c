"""Progress of a study: a bar on a terminal, and a line for each case that has ended."""

from __future__ import annotations

import sys
import time
from datetime import timedelta
from types import TracebackType
from typing import TextIO

from harness.study.cases import Case, Outcome

BAR_WIDTH = 24


def tell(message: str) -> None:
    """Say one line on standard error, where it does not mix with results."""
    print("harness:", " ".join(message.split()), file=sys.stderr)


class Display:
    """Shows cases as they run; a context that leaves the terminal's line clean.

    Args:
        total: number of cases to run.
        stream: where to write, a terminal or not.
    """

    def __init__(self, total: int, stream: TextIO) -> None:
        self.total = total
        self.stream = stream
        self.done = 0
        self.running: dict[str, float] = {}
        self.started = time.monotonic()
        self.on_terminal = stream.isatty()

    def __enter__(self) -> Display:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._write_over("")

    def advanced(self, case: Case, fraction: float) -> None:
        """A running case has come to `fraction`, 0 to 1."""
        self.running[case.key] = fraction
        self._write_over(self.bar())

    def finished(self, case: Case, outcome: Outcome) -> None:
        """A case has ended, well or not."""
        self.done += 1
        self.running.pop(case.key, None)
        told = ", ".join(filter(None, (outcome.status, outcome.headline, outcome.message)))
        line = f"[{self.done}/{self.total}] {case.label}: {told}, {outcome.seconds:.1f} s"
        self._write_over("")
        print(line, file=self.stream, flush=True)
        self._write_over(self.bar())

    def bar(self) -> str:
        """The bar with cases done, mean progress of those running, and time left."""
        share = (self.done + sum(self.running.values())) / self.total
        filled = round(share * BAR_WIDTH)
        texts = [f"{'█' * filled:░<{BAR_WIDTH}} {self.done}/{self.total} cases"]
        if self.running:
            mean = sum(self.running.values()) / len(self.running)
            texts.append(f"{len(self.running)} running, at {mean:.0%}")
        if share > 0:
            left = (time.monotonic() - self.started) * (1 - share) / share
            texts.append(f"{timedelta(seconds=round(left))} left")
        return ", ".join(texts)

    def _write_over(self, text: str) -> None:
        """Replace the terminal's line; elsewhere there is none to replace."""
        if self.on_terminal:
            self.stream.write(f"\r\x1b[K{text}")
            self.stream.flush()
