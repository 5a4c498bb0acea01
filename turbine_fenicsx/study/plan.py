"""Runs of a study: every case is made and checked before the first one starts."""

from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import isfinite, prod
from pathlib import PurePath
from typing import Any

from turbine_fenicsx.case.files import hash_files, make_absolute
from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote
from turbine_fenicsx.study.file import Study, flatten
from turbine_fenicsx.turbine.case.case import Case
from turbine_fenicsx.turbine.tables.reduction import FOLDER
from turbine_fenicsx.turbine.tables.tables import Tables
from turbine_fenicsx.turbine.tables.turbulence import FOLDER as TURBULENCE_FOLDER

_LONGEST_NAME = 120

MOST_RUNS = 10_000
"""Runs of a study, each of which has a separate folder."""


@dataclass(frozen=True, eq=False)
class Run:
    """One run of a study.

    Attributes:
        name: Name of its folder, made of its changes.
        changes: Values of the keys that it changes, by dotted key.
        text: The complete case file of the run, with a hash of it and of the files it names. A run
            whose folder holds the same text and a summary is finished.
    """

    name: str
    changes: dict[str, Any]
    case: Case
    text: str

    def value(self, key: str) -> Any:
        """Value of a dotted key of the case, in SI units."""
        found: Any = self.case
        for name in key.split("."):
            found = getattr(found, name)
        return found


def plan(study: Study, overrides: Iterable[str] = ()) -> list[Run]:
    """All runs of a study: each ``[[run]]`` with each combination of the ``[grid]``.

    Args:
        overrides: More changes of all runs, such as ``"time.end=1.0"``.
    """
    overrides = list(overrides)
    for override in overrides:
        key = override.partition("=")[0].strip()
        if key in study.varied:
            raise InputError(f"{key!r} is varied by the study and cannot be set for all runs")
    common = [*as_overrides(study.set), *overrides]
    combinations = _combine(study)
    names = _name_folders(combinations)
    for name, uses in Counter(names).items():
        if uses > 1:
            raise InputError(f"two runs are the same: {_name(combinations[names.index(name)])!r}")
    runs = make_runs(study.case, common, dict(zip(names, combinations, strict=True)))
    _check_convergence(study, runs)
    return runs


def make_runs(
    path: str, common: Sequence[str], changes: Mapping[str, Mapping[str, Any]]
) -> list[Run]:
    """Runs of a case, all of which are looked at before the first one starts.

    Args:
        path: The case file.
        common: Changes of all runs, such as ``"time.end=1.0"``.
        changes: Changes of each run by dotted key, by the name of its folder.

    Raises:
        InputError: with one sentence for every mistake, or if two runs are the same.
    """
    runs: list[Run] = []
    mistakes: dict[str, list[str]] = {}
    for name, own in changes.items():
        try:
            case = _load(path, [*common, *as_overrides(own)])
            runs.append(Run(name, dict(own), case, format_case(case)))
        except InputError as error:
            for sentence in str(error).splitlines():
                mistakes.setdefault(sentence, []).append(name)
    if mistakes:
        raise InputError(
            "\n".join(
                sentence if len(names) == len(changes) else f"run {names[0]!r}: {sentence}"
                for sentence, names in mistakes.items()
            )
        )
    _refuse_equal_runs(runs)
    return runs


def _refuse_equal_runs(runs: Sequence[Run]) -> None:
    """No two runs have the same values of all keys, in whatever units they are given."""
    seen: dict[str, Run] = {}
    for run in runs:
        other = seen.setdefault(run.text.splitlines()[0], run)
        if other is not run:
            one, two = _name(other.changes), _name(run.changes)
            raise InputError(f"two runs are the same: {one!r} and {two!r}")


def _load(path: str, overrides: Sequence[str]) -> Case:
    """Read a case; bases and turbulence are kept beside it, for all runs together."""
    case = Case.load(path, overrides)
    parts = {"blade": case.has_reduced_blades, "tower": case.has_reduced_tower}
    shared = []
    for name, moves_by_vectors in parts.items():
        table = getattr(case, name)
        none = table.reduction.file is None and table.reduction.folder is None
        if moves_by_vectors and table.model == "reduced" and none:
            shared.append(f"{name}.reduction.folder={FOLDER}")
    made = case.wind.turbulence
    if made.is_made and made.folder is None:
        shared.append(f"wind.turbulence.folder={TURBULENCE_FOLDER}")
    return Case.load(path, [*shared, *overrides]) if shared else case


def format_case(case: Case) -> str:
    """A case as a case file that means the same in any folder.

    Returns:
        TOML with all keys that are set, files by their absolute paths. The first line has a hash of
        all keys, set or not, and of the contents of the files.
    """
    digest = hashlib.sha256()
    tables = make_absolute(case.model_dump(), Tables)
    for key, value in flatten(tables):
        digest.update(f"{key} = {json.dumps(value)}\n".encode())
    digest.update(json.dumps(hash_files(tables, Tables)).encode())
    lines = [
        f"{key} = {json.dumps(value, ensure_ascii=False)}\n"  # JSON values are TOML values
        for key, value in flatten(make_absolute(case.model_dump(exclude_unset=True), Tables))
        if value is not None
    ]
    return f"# a run of a study, hash {digest.hexdigest()}\n{''.join(lines)}"


def group_series(runs: Sequence[Run], key: str) -> dict[str, list[Run]]:
    """Runs that differ in one key only, by a label made of all their other changes."""
    found: dict[str, list[Run]] = {}
    for run in runs:
        others = {name: value for name, value in run.changes.items() if name != key}
        found.setdefault(_name(others) if others else "", []).append(run)
    return found


def _combine(study: Study) -> list[dict[str, Any]]:
    """The changes of each run."""
    number = max(len(study.run), 1) * prod(map(len, study.grid.values()))
    if number > MOST_RUNS:
        raise InputError(f"the study has {number} runs, expected at most {MOST_RUNS}")
    return [
        {**changes, **dict(zip(study.grid, values, strict=True))}
        for changes in study.run or [{}]
        for values in product(*study.grid.values())
    ]


def as_overrides(changes: Mapping[str, Any]) -> list[str]:
    """Changes in the form of the command line; JSON values are TOML values."""
    for key, value in changes.items():
        if not _is_plain(value):
            raise InputError(
                f"{key} = {quote(value)}: give finite numbers, strings, true or false, or lists of "
                "them"
            )
    return [f"{key}={json.dumps(value, ensure_ascii=False)}" for key, value in changes.items()]


def _is_plain(value: Any) -> bool:
    """Whether a value can stand on the command line."""
    if isinstance(value, list):
        return all(map(_is_plain, value))
    return isinstance(value, str | bool | int) or (isinstance(value, float) and isfinite(value))


def _name_folders(combinations: Sequence[Mapping[str, Any]]) -> list[str]:
    """Names of folders, different ones for different changes."""
    texts = [json.dumps(changes, sort_keys=True) for changes in combinations]
    names = [_name(changes) for changes in combinations]
    uses = Counter(names)
    return [
        name
        if uses[name] == 1 and len(name) <= _LONGEST_NAME
        else f"{name[:_LONGEST_NAME]}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"
        for name, text in zip(names, texts, strict=True)
    ]


def _name(changes: Mapping[str, Any]) -> str:
    """Changes as a readable name, for example ``mesh.elements=4x4x24,mesh.degree=2``.

    Lists of files are the names of these without ending, for example ``wind.box.files=u+v+w``.
    """

    def short(value: Any) -> str:
        if not isinstance(value, list):
            return str(value)
        if all(isinstance(x, str) for x in value):
            return "+".join(PurePath(x).stem for x in value)
        return "x".join(map(short, value))

    text = ",".join(f"{key}={short(value)}" for key, value in changes.items())
    return re.sub(r"[^\w.,=+-]+", "_", text) or "base"


def _check_convergence(study: Study, runs: Sequence[Run]) -> None:
    """The refined key must have enough positive values."""
    if study.convergence is None:
        return
    key, reference = study.convergence.key, study.convergence.reference
    for run in runs:
        value = run.value(key)
        numbers = list(value) if isinstance(value, list | tuple) else [value]
        if not all(isinstance(x, int | float) and x > 0 for x in numbers):
            raise InputError(
                f"convergence.key = {key!r}: its values must be positive numbers or lists of them, "
                f"not {value!r}"
            )
    needed = 3 if isinstance(reference, str) else 2
    for label, members in group_series(runs, key).items():
        if len(members) < needed:
            raise InputError(
                f"convergence.reference = {reference!r} needs at least {needed} values of {key!r}"
                + (f" with {label!r}" if label else "")
                + f", not {len(members)}"
            )
