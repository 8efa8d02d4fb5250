"""Tests of the product, the measurements and the set-up."""
