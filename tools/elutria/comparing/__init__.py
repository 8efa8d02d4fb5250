"""A measured partition curve beside a computed one."""
