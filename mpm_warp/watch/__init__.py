"""What ends a run that is not sound."""
