"""A grid that travels with a penetrometer: the ground around it, and the soil that enters."""
