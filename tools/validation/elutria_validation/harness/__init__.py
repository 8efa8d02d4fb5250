"""What chapters, benchmarks, fits and tests share: cases, programs, timings, result files."""
