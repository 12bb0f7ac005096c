"""Parts of a scene, one file each: declaration, kernel, place in the plan.

`part.py` says what all have in common, `velocity_interpolation.py` how soil moves between nodes.
"""
