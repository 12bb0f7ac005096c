"""Pictures of which steps and settings a run survives."""
