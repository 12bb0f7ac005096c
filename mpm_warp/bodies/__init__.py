"""Bodies of any shape on a common grid, each with a velocity field of its own, in contact."""
