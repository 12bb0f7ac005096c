"""The command line: what commands and options there are, their values and their help."""
