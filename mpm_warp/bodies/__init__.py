"""The second solver: bodies of any shape in contact on a uniform grid.

Each body has a velocity field of its own; soil that fills its grid is the first solver's.
"""

from mpm_warp.bodies import step as step  # tells make_plan how bodies are planned
