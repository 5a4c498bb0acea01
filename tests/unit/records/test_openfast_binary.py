"""Claims about ``history.outb``: readers of OpenFAST's files find the numbers of the text."""

import numpy as np
import pytest

from turbine_fenicsx.records.openfast_binary import write_openfast_binary


def write(folder, times):
    values = np.array([[t, 1e3 * np.sin(t), 7.0] for t in times])
    head = [
        "",
        "made",
        "",
        "",
        "Description: a run",
        "",
        "Time\tRotThrust\tRotSpeed",
        "(s)\t(kN)\t(rpm)",
    ]
    rows = ["\t".join(f"{x:.6E}" for x in row) for row in values]
    path = folder / "history.out"
    path.write_text("\n".join([*head, *rows]) + "\n")
    write_openfast_binary(path)
    return values


@pytest.mark.parametrize(
    "times", [np.linspace(0.1, 20.0, 200), np.geomspace(0.1, 20.0, 200), [1.0]]
)
def test_openfast_io_reads_the_numbers_of_the_text(tmp_path, times):
    FASTOutputFile = pytest.importorskip("openfast_io.FAST_output_reader").FASTOutputFile
    values = write(tmp_path, times)
    found = FASTOutputFile(str(tmp_path / "history.outb"))
    assert found.info["attribute_names"] == ["Time", "RotThrust", "RotSpeed"]
    assert found.info["attribute_units"] == ["s", "kN", "rpm"]
    assert found.info["description"] == "Description: a run"
    assert np.allclose(found.data[:, 0], values[:, 0], rtol=2e-6)
    span = np.ptp(values[:, 1])
    assert np.allclose(found.data[:, 1], values[:, 1], rtol=1e-6, atol=span * 2.0**-16)
    assert np.allclose(found.data[:, 2], 7.0, rtol=1e-6)
