"""Cone penetration: the test, and a cone from first touch."""
