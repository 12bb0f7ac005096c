"""A sounding: a cone test through ground that changes with depth."""
