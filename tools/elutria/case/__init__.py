"""A case on disk: its feed, its settings, copies of it."""
