"""Results held against references, tolerances and each other."""
