"""Running cases: one, or a sweep of them side by side."""
