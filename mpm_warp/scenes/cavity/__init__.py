"""Cavities that expand in undrained clay."""
