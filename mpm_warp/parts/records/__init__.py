"""What a run records of itself: energy, where its soil came from, how far it was sheared."""
