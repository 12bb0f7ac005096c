"""What a step of the simulator costs."""
