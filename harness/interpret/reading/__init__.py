"""Readers of files of measured tests: headings, units, and cells as they stand there."""
