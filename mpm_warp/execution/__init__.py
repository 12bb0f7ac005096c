"""A plan on a device: replayed steps, threads, batches."""
