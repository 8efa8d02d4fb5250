"""Laws of the field that know no case: drag, size distributions."""
