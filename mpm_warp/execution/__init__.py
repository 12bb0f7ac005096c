"""A plan on a device: recorded steps, the threads that replay them."""

THREAD_COUNTS = (1, 2, 4)
"""Numbers of threads that a run may have on a processor; each divides the shares of its plan.

They are here because the command line lists them and must not wait for the import of Warp.
"""
