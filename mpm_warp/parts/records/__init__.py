"""What a run notes of itself: energy, where its soil came from, how far it was sheared."""
