"""Where nodes and cells are, and where a material point is among them."""
