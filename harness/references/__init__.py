"""What results are compared with: published values, each with its source and its range."""
