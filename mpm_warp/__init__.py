"""Axisymmetric and plane-strain material point method on NVIDIA Warp kernels."""
