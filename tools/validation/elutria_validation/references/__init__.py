"""Published values and closed forms, written apart from the code that they judge."""
