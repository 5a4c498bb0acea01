"""What is in a ``history.csv``, for tests."""

import csv

import numpy as np


def read_lines(folder):
    """Its lines without the wall time."""
    return [line.rsplit(",", 1)[0] for line in (folder / "history.csv").read_text().splitlines()]


def read_columns(folder, name="history.csv"):
    """Its columns by name, as arrays."""
    with (folder / name).open(newline="") as file:
        header, *values = csv.reader(file)
    return dict(zip(header, np.array(values, dtype=float).T, strict=True))


def read_rows(folder):
    """Its rows, a dictionary of numbers by name for each."""
    with (folder / "history.csv").open(newline="") as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
