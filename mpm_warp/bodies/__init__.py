"""The second solver: bodies of any shape on a plain grid, each with its own velocity, in contact."""

from mpm_warp.bodies import planning as planning  # tells make_plan how bodies are planned
