"""References: each module here has NAME, HELP and run(options), as benchmarks have."""
