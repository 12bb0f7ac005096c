"""Blocks: one that slides on a base, and one in free flight."""
