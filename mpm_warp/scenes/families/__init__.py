"""What several scenes have in common, or what a scene is too long for: not scenes themselves."""
