"""Where windIO files are: beside a case, or among the examples of an installed windIO."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.foundation.text_files import quote


def find_turbine_file(name: str, beside: str | os.PathLike[str] = ".") -> Path:
    """A windIO file by its name.

    Args:
        name: A path, or the bare name of one of windIO's examples, such as
            "IEA-22-280-RWT.yaml"; a file of that name beside the case is taken first.
        beside: Folder that a relative path starts from, that of the case.

    Raises:
        InputError: if there is none; the sentence says where to get the examples.
    """
    try:
        path = Path(beside, name)
        if path.exists():
            return path
        windio = find_windio()
        examples = windio and windio / "examples" / "turbine"
        if examples and Path(name).name == name and (examples / name).is_file():
            return examples / name
    except (OSError, ValueError) as error:  # too long, a null byte
        raise InputError(f"{quote(name)} is no name of a file: {error}") from None
    known = sorted(p.name for p in examples.glob("IEA-*RWT.yaml")) if examples else []
    have = f"windIO has {' and '.join(known)}" if known else "no windIO is installed"
    raise InputError(
        f"there is no windIO file {quote(name)} in {quote(os.fspath(beside))}, and {have}; "
        "`pip install --no-deps windIO` brings the turbines IEA-15-240-RWT.yaml and "
        "IEA-22-280-RWT.yaml"
    )


def find_windio() -> Path | None:
    """The folder of an installed windIO, found without importing it or what that needs."""
    spec = importlib.util.find_spec("windIO")
    places = spec.submodule_search_locations if spec else None
    return Path(places[0]) if places else None
