"""Adhesion and friction on a rigid surface."""
