"""Single material points on strain paths."""
