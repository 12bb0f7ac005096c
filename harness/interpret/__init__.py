"""From a measured cone test to undrained shear strength, with its error and the causes of it."""
