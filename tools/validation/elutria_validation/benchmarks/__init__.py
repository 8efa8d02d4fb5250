"""Benchmarks: each module here has NAME, HELP and run(options); see common.py."""
