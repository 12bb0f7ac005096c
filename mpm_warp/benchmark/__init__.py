"""What a step costs: the speed of a run, of its stages, and of a bare step to compare with."""
