"""Elastic bars, columns and rings: static loads, waves and impacts."""
