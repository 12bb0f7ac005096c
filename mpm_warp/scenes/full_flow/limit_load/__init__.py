"""Limit loads of round bodies, moved by a small part of their radius."""
