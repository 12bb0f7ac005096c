"""Run the notebook studies/tour.ipynb in an empty folder, and store what its cells give.

python tests/tour.py
"""

import base64
import io
import os
import tempfile
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient
from PIL import Image

ROOT = Path(__file__).parents[1]
TOUR = ROOT / "studies" / "tour.ipynb"
COLOURS = 64
"""Colours of a stored picture, which makes it a third as large."""


def executed(folder: Path) -> Any:
    """The notebook after its cells have run in a folder; the same each time on one machine."""
    notebook = nbformat.read(TOUR, as_version=4)
    metadata = dict(notebook.metadata)
    resources = {"metadata": {"path": str(folder)}}
    client = NotebookClient(
        notebook, record_timing=False, coalesce_streams=True, resources=resources
    )
    client.execute(env=os.environ | {"PYTHONPATH": str(ROOT)})
    notebook.metadata = metadata  # without the version of Python
    return notebook


def smaller(png: str) -> str:
    """A picture of few colours, both as a notebook has it, in base 64."""
    content = io.BytesIO()
    image = Image.open(io.BytesIO(base64.b64decode(png)))
    image.convert("RGB").quantize(COLOURS).save(content, "PNG", optimize=True)
    return base64.b64encode(content.getvalue()).decode()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as empty:
        made = executed(Path(empty))
    for cell in made.cells:
        for output in cell.get("outputs", ()):
            if "image/png" in output.get("data", {}):
                output.data["image/png"] = smaller(output.data["image/png"])
    nbformat.write(made, TOUR)
