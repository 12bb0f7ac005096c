"""What the edges of a grid do: nodes held, an elastic far field, a wall that moves."""
