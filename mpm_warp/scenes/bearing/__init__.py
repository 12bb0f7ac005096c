"""Limit loads of footings and cones at the surface of the ground."""
