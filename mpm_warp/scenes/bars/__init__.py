"""A bar that is drawn out."""
