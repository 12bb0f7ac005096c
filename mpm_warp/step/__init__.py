"""The stages that every run has, in order."""
