"""Results compared with references, tolerances and each other."""
