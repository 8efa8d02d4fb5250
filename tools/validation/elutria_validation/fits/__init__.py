"""Where the fitted constants of solver and tools come from: each module fits some and judges them.

`python -m elutria_validation.fits` prints them all: the constant as it stands in the source, the
value that the fit gives today, the fit's residual, and the error on data that it was not fitted to.
"""
