"""The open benchmark: cases that any code can run, submissions of codes, and scores."""
