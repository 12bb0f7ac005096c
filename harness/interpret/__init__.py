"""From a measured cone test to undrained shear strength, with its error and where that is from."""
