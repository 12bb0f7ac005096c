"""The page of the open benchmark: all submissions beside one another."""

from collections.abc import Sequence

from harness.benchmark.cases import META_KEYS, Submission
from harness.benchmark.score import Score, case_rows, summary_rows
from harness.pictures.drawing.plot_parts import MAKER
from harness.report.report import TEMPLATES, embedded


def benchmark_page(
    submissions: Sequence[Submission], found: Sequence[Score], picture: bytes, against: str
) -> str:
    """The page as text.

    Args:
        submissions: all that were scored.
        found: their scores.
        picture: PNG of errors over run time.
        against: the submission that is the yardstick where no exact value is known.
    """
    cases = {it.case.name: it.case for it in found}
    exact = {
        name: " to ".join(dict.fromkeys(f"{it:g}" for it in case.exact)) if case.exact else ""
        for name, case in cases.items()
    }
    return TEMPLATES.get_template("benchmark.html").render(
        maker=MAKER,
        against=against,
        picture=embedded("errors over run time", picture),
        summary=summary_rows(found),
        meta=[
            ["submission", *META_KEYS],
            *([it.name, *(it.meta.get(key, "") for key in META_KEYS)] for it in submissions),
        ],
        titles=[
            ["case", "what is computed", "unit", "exact"],
            *([it.name, it.title, it.unit, exact[it.name]] for it in cases.values()),
        ],
        results=case_rows(found),
    )
