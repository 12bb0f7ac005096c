"""Constitutive models, one file each."""
