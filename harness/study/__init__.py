"""From a study file to its cases: definitions in TOML, read and checked."""
