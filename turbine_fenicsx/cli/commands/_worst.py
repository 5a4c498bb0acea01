"""The picture of the moment nearest to failure."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

PICTURE = "worst.png"


def draw_worst(recovery: Any, worst: Any) -> Path:
    """Draw the blade of a `RunRecovery` at a `WorstMoment`; the picture. Collective.

    Raises:
        InputError: if it cannot be drawn.
    """
    from turbine_fenicsx.foundation.parallel import on_rank0
    from turbine_fenicsx.postprocessing.pictures import render_hot_spot
    from turbine_fenicsx.turbine.run.chosen_rows import find_rows

    run = recovery.run
    comm, picture = run.turbine.comm, Path(run.folder / PICTURE)
    with TemporaryDirectory() as scratch:  # each rank makes one, all write into that of rank 0
        path = Path(comm.bcast(scratch)) / "fields.xdmf"
        rows = find_rows(run.motion.times, [worst.time])
        recovery.find_fields([worst.criterion]).write(path, rows)
        where, ply, *_ = str(worst).splitlines()
        lines = filter(None, [run.turbine.case.title, where, ply.partition(":")[0]])
        draw = partial(render_hot_spot, path, picture, field=worst.criterion)
        on_rank0(comm, partial(draw, title="\n".join(lines)))
    return picture
