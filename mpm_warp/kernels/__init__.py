"""Warp kernels, one file for each stage of the step, made by factories."""
