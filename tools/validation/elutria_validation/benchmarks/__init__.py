"""Benchmarks: each module here that has NAME, HELP and run(job, options) is one."""
