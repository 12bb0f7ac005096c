"""Pictures of the method itself: its order, its error over run time, where it is stable."""
