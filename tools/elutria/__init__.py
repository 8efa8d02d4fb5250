"""Elutria: air classification computed with gas and particles, from feed to partition curve."""

import os

# arrays here are long and thin: threads of BLAS only get in each other's way
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

__version__ = "0.1.0"
