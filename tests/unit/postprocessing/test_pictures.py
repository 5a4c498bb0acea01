"""Pictures and movies of the turbine from ``fields.xdmf``."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from outputs import HUB_CENTRE, PARTS, turbine, turned

from turbine_fenicsx.foundation.errors import InputError
from turbine_fenicsx.postprocessing import pictures
from turbine_fenicsx.postprocessing.pictures import Look

needs_pyvista = pytest.mark.skipif(
    importlib.util.find_spec("pyvista") is None, reason="PyVista, which draws, is missing"
)
needs_ffmpeg = pytest.mark.skipif(
    importlib.util.find_spec("imageio_ffmpeg") is None, reason="imageio-ffmpeg is missing"
)


def drawing(function, *arguments, **options):
    """Draw, or skip where there is no graphics library."""
    try:
        return function(*arguments, **options)
    except InputError as problem:
        if "no graphics library" in str(problem):
            pytest.skip(str(problem))
        raise


def pixels(path: Path) -> np.ndarray:
    from PIL import Image

    return np.asarray(Image.open(path).convert("RGB"), dtype=int)


READ = """
import json, sys, pyvista
from turbine_fenicsx.postprocessing.field_reader import FieldReader
from turbine_fenicsx.records.parts import Parts
path, text = sys.argv[1:]
readers = [FieldReader(path, Parts.from_text(text), scale) for scale in (1.0, 3.0)]
print(json.dumps([readers[k].grid(1).points.tolist() for k in (0, 1, 1)]))
"""


@needs_pyvista
@pytest.mark.parametrize("pitch", [0.0, 1.4])
def test_bending_is_scaled_but_neither_turning_nor_pitch(tmp_path, pitch):
    path = turbine(tmp_path / "fields.xdmf", bend=2.0, pitch=pitch)
    # in a process of its own, as in use: VTK does not get on with all other libraries
    command = [sys.executable, "-c", READ, path, PARTS.to_text()]
    read = subprocess.run(command, capture_output=True, text=True)
    assert read.returncode == 0, read.stderr
    plain, *twice = np.array(json.loads(read.stdout))
    moved = np.zeros_like(plain)
    moved[16:] = np.where(np.linalg.norm(plain[16:] - HUB_CENTRE, axis=1) > 50.0, 4.0, 0.0)[
        :, None
    ] * [0.0, 0.0, 1.0]
    for scaled in twice:
        # displacements are written in single precision: some 1e-6 of 60 m, of roots 2 m wide
        assert np.abs(scaled - plain - moved).max() < 1e-3
        assert np.array_equal(scaled[:16], plain[:16])  # nacelle and hub
    upright = plain[16:24].mean(axis=0) - HUB_CENTRE
    assert upright[:2] == pytest.approx(29.25 * turned(1.0)[:2, 1], abs=1e-4)


def test_nearest_time_is_taken_and_others_are_refused():
    times = np.array([0.0, 0.1, 0.2])
    assert [pictures.find_nearest_step(times, t) for t in (0.0, 0.04, 0.06, 0.2)] == [0, 0, 1, 2]
    for t in (-0.1, 0.21):
        with pytest.raises(InputError, match=r"is outside of the run, .* from 0 s to 0\.2 s"):
            pictures.find_nearest_step(times, t)


@pytest.mark.parametrize(
    ("speed", "steps", "rate"), [(1.0, 101, 10.0), (6.0, 101, 60.0), (9.0, 51, 45.0)]
)
def test_movie_runs_at_its_speed_with_at_most_60_frames_a_second(speed, steps, rate):
    found = pictures.choose_movie_steps(np.linspace(0.0, 10.0, 101), speed)
    assert (len(found[0]), found[1]) == (steps, pytest.approx(rate))


def test_movie_needs_two_times():
    with pytest.raises(InputError, match="two times or more"):
        pictures.choose_movie_steps([0.0], 1.0)


@needs_pyvista
def test_pictures_of_several_times_share_their_colours(tmp_path):
    path = turbine(tmp_path / "fields.xdmf", (0.0, 0.5, 1.0))
    done = []
    first, last = drawing(
        pictures.render_times,
        path,
        tmp_path,
        [0.0, 1.0, 0.9],
        Look(size=(960, 540)),
        done=lambda: done.append(1),
    )
    assert [first.name, last.name] == ["turbine_t0.png", "turbine_t1.png"]
    assert len(done) == 2
    before, after = pixels(first), pixels(last)
    assert before.shape == (540, 960, 3)
    white = (after > 252).all(axis=-1)
    assert white[:, :15].all()
    assert 0.02 < 1.0 - white.mean() < 0.4
    legend = np.s_[:, 800:]
    assert (before[legend] == after[legend]).all()  # the same numbers on the same colours
    assert len(np.unique(after[legend].reshape(-1, 3), axis=0)) > 100
    # without stress all blades are light grey; then the last has the largest stress of all
    reds = [int((p[:, :750, 0] - p[:, :750, 1] > 80).sum()) for p in (before, after)]
    assert reds[0] == 0
    assert reds[1] > 250


@needs_pyvista
@pytest.mark.parametrize(
    "look",
    [
        Look(scalar=None, view="front", size=(640, 360)),
        Look(scalar="displacement", scale=4.0, view="side", size=(400, 300)),
    ],
)
def test_every_look_shows_something(tmp_path, look):
    path = turbine(tmp_path / "fields.xdmf")
    png = drawing(pictures.render_turbine, path, tmp_path / "turbine.png", look=look)
    shown = pixels(png)
    assert shown.shape == (look.size[1], look.size[0], 3)
    assert 0.01 < (shown < 250).any(axis=-1).mean() < 0.4


@needs_pyvista
@pytest.mark.parametrize("title", ["a title", r"50 % $\frac{"])
def test_a_title_stands_in_the_corner(tmp_path, title):
    path = turbine(tmp_path / "fields.xdmf")
    plain, named = (
        pixels(
            drawing(
                pictures.render_turbine,
                path,
                tmp_path / f"{k}.png",
                look=Look(scalar=None, size=(640, 360), title=text),
            )
        )
        for k, text in enumerate(("", title))
    )
    different = (plain != named).any(axis=-1)
    assert different[300:, :300].any()
    assert not different[:290].any()


@needs_pyvista
@needs_ffmpeg
def test_movie_has_a_frame_for_every_time(tmp_path):
    import imageio_ffmpeg

    path = turbine(tmp_path / "fields.xdmf", (0.0, 0.5, 1.0))
    done = []
    mp4 = drawing(
        pictures.render_movie,
        path,
        tmp_path / "a.mp4",
        2.0,
        Look(size=(640, 360)),
        done=lambda: done.append(1),
    )
    assert len(done) == 3
    frames = imageio_ffmpeg.read_frames(str(mp4))
    meta = next(frames)
    assert (meta["size"], meta["fps"]) == ((640, 360), 4.0)
    shown = [np.frombuffer(frame, np.uint8).astype(int) for frame in frames]
    assert len(shown) == 3
    assert np.abs(shown[2] - shown[0]).max() > 100  # it moves


@needs_pyvista
@pytest.mark.parametrize(
    ("look", "message"),
    [
        (
            Look(scalar="heat"),
            "no field 'heat', but cauchy_stress_norm, coupling, deflection, displacement, part,",
        ),
        (Look(coloured=("nose",)), "no part 'nose', but nacelle, hub, blade_1, blades, blade_2"),
        (Look(view="above"), "there is no view 'above', but oblique, corner, front, side$"),
    ],
)
def test_what_cannot_be_drawn_is_one_sentence(tmp_path, look, message):
    path = turbine(tmp_path / "fields.xdmf")
    with pytest.raises(InputError, match=message) as caught:
        pictures.render_turbine(path, tmp_path / "turbine.png", look=look)
    assert "\n" not in str(caught.value)


STRICT = """
import json, sys, pyvista
from turbine_fenicsx.postprocessing import scene
def add(plotter, mesh, **how):  # a VTK that refuses numbers of NumPy where it wants Python's
    wrong = {name for name, value in how.items() if type(value).__module__ == "numpy"}
    if wrong:
        raise ValueError(f"NumPy's: {wrong}")
pyvista.Plotter.add_mesh = add
raise SystemExit(scene.main())
"""


@needs_pyvista
def test_vtk_gets_no_numbers_of_numpy(tmp_path, monkeypatch):
    python = tmp_path / "python"
    (tmp_path / "strict.py").write_text(STRICT)
    python.write_text(f"#!/bin/sh\nexec {sys.executable} {tmp_path}/strict.py\n")
    python.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(python))
    path = turbine(tmp_path / "fields.xdmf")
    drawing(pictures.render_turbine, path, tmp_path / "turbine.png")


def test_missing_graphics_library_does_not_end_the_caller(tmp_path, monkeypatch):
    dying = tmp_path / "python"
    dying.write_text("#!/bin/sh\nkill -SEGV $$\n")
    dying.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(dying))
    path = turbine(tmp_path / "fields.xdmf")
    with pytest.raises(InputError, match=r"signal 11.* no graphics library .*apt install libegl1"):
        pictures.render_turbine(path, tmp_path / "turbine.png")


@pytest.mark.parametrize("package", ["pyvista", "imageio_ffmpeg"])
def test_missing_package_is_one_sentence(tmp_path, monkeypatch, package):
    (tmp_path / f"{package}.py").write_text(f"raise ModuleNotFoundError('no {package} here')\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    path = turbine(tmp_path / "fields.xdmf")
    need = {"pyvista": "PyVista: pip install pyvista", "imageio_ffmpeg": "imageio-ffmpeg: pip"}
    with pytest.raises(InputError, match=f"turbine.mp4: .* need {need[package]}"):
        pictures.render_movie(path, tmp_path / "turbine.mp4")
