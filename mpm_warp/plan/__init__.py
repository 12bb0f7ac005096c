"""A run as data: arrays, launches, a builder; no scene is known here."""
