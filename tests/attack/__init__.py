"""Attacks at full size, see `tests.attack.__main__`; the suite of tests repeats them small."""
