"""Pictures of the soil around a penetrometer, from the snapshots of a case."""
