"""Cases are run: in worker processes, on a cluster, again, or against exact solutions."""
