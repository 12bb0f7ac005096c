"""Loads on nodes and what resists their motion: weight, given forces, damping."""
