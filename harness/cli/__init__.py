"""The command line: its options, its commands and how they end."""
