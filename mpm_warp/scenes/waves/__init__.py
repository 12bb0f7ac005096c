"""Waves along columns of soil."""
