"""Fields: their declaration, their checks, their flat form, and the names and numbers in texts."""
