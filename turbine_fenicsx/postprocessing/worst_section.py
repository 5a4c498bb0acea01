"""The moment nearest to failure on the page of a run, from the files of ``recover``."""

from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing import failure_panels
from turbine_fenicsx.postprocessing.page import embed_figure, format_note
from turbine_fenicsx.postprocessing.plots import draw
from turbine_fenicsx.records.output_folder import read_history, read_tables

PANELS = (failure_panels.largest_index, failure_panels.worst_place)


def format_worst(folder: Path) -> str:
    """The contents of ``worst.json``, ``worst.png`` and ``plies.csv``; empty without the first."""
    worst = read_tables(folder / "worst.json")
    if worst is None:
        return ""
    try:
        words = _describe(worst)
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{folder / 'worst.json'} is not a moment nearest to failure") from None
    texts = [f"<p>{escape(words)}</p>\n"]
    picture, plies = folder / "worst.png", folder / "plies.csv"
    if picture.exists():
        texts.append(embed_figure(picture, "The blade at this moment, and the place from near by."))
    if plies.exists():
        with TemporaryDirectory() as scratch:
            try:
                (path,) = draw([read_history(plies)], PANELS, [Path(scratch) / "failure.png"])
            except ImportError as error:
                return "".join([*texts, format_note(f"There are no diagrams: {error}.")])
            caption = "Failure index of the plies in all blades, and the place of the largest."
            texts.append(embed_figure(path, caption))
    return "".join(texts)


def _describe(worst: dict[str, Any]) -> str:
    """The moment in two sentences."""
    return (
        f"At t = {worst['time']:.4g} s the index of {worst['criterion']} is {worst['index']:.3g} "
        f"in {worst['panel'].replace('_', ' ')} of blade {worst['blade']:d}, "
        f"{worst['place']:.4g} m from the root; 1 is failure. It is ply {worst['ply']:d} of "
        f"{worst['plies']:d} from outside, {worst['material']} at {worst['angle']:.3g} deg, and "
        f"most {worst['mode']}."
    )
