"""A bar and a column of soil that strike a rigid wall."""
