"""What Jupyter shows of an object: a name and a table of its values."""

from collections.abc import Iterable
from html import escape


def html_table(title: str, rows: Iterable[Iterable[object]]) -> str:
    """A table in HTML; each row has the texts of its cells."""
    cells = ("".join(f"<td>{escape(str(cell))}</td>" for cell in row) for row in rows)
    body = "".join(f"<tr>{row}</tr>" for row in cells)
    return f"<div><b>{escape(title)}</b><table>{body}</table></div>"
