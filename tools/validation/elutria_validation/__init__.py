"""Elutria's measuring half: what verifies the solver and the tools, and what times them.

Rooms, each knowing only those before it: references (published values and closed forms), harness
(cases, programs, timings), book (rows, chapters, pages), chapters (verification), benchmarks, fits.
Nothing of the product imports it.
"""
