"""Elutria: air classification computed with gas and particles, from feed to partition curve."""

__version__ = "0.1.0"
