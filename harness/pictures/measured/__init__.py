"""Pictures of measured ground: strength of a test, and computed beside measured factors."""
