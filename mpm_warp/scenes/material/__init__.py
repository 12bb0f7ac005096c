"""Single material points on strain paths and in element tests."""
