"""A cone penetration test through ground that changes with depth."""
