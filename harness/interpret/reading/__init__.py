"""From the file of a measured test, of whatever format, to depth, qc, fs and u2 in SI units."""
