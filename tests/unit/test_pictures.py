"""Pictures and movies of the turbine from ``fields.xdmf``."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from outputs import HUB_CENTRE, turbine, turned

from turbine_fenicsx import pictures
from turbine_fenicsx.deformation import scaled_deformation
from turbine_fenicsx.errors import InputError
from turbine_fenicsx.pictures import Look
from turbine_fenicsx.rotations import E1, rotation_about
from turbine_fenicsx.scene import SIZE

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


def test_turning_is_not_scaled_but_bending_is():
    rng = np.random.default_rng(1)
    X = rng.normal(size=(20, 3))
    hub, blade = np.arange(20) < 8, np.arange(20) >= 12  # the nacelle is between them
    R, shift = rotation_about(E1 + 2.0 * HUB_CENTRE, 2.5), np.array([3.0, -1.0, 0.5])
    rigid = X @ R.T + shift
    bend = np.where(blade[:, None], 0.1 * rng.normal(size=X.shape), 0.0)
    nacelle = ~hub & ~blade
    bend[nacelle] = 7.0  # turns otherwise than the hub, and stays where it is
    x = rigid + bend
    found = scaled_deformation(x, x - X, hub, blade, 10.0)
    assert np.allclose(found[blade], (rigid + 10.0 * bend)[blade], atol=1e-12)
    assert np.array_equal(found[~blade], x[~blade])
    assert np.allclose(scaled_deformation(x, x - X, hub, blade, 0.0)[blade], rigid[blade])


def test_flat_hub_is_turned_and_not_mirrored():
    X = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [3, 1, 2]], dtype=float)
    x = X @ rotation_about(E1, 3.0).T
    hub = np.arange(5) < 4
    assert np.allclose(scaled_deformation(x, x - X, hub, ~hub, 5.0), x)


def test_scaling_needs_a_hub():
    with pytest.raises(ValueError, match="there is no hub"):
        scaled_deformation(np.eye(3), np.zeros((3, 3)), np.zeros(3, bool), np.ones(3, bool), 2.0)


READ = """
import json, sys, pyvista
from turbine_fenicsx.deformation import read_grid
reader = pyvista.get_reader(sys.argv[1])
print(json.dumps([read_grid(reader, 1, scale).points.tolist() for scale in (1.0, 3.0, 3.0)]))
"""


@needs_pyvista
def test_grid_is_scaled_once_however_often_it_is_read(tmp_path):
    path = turbine(tmp_path / "fields.xdmf", bend=2.0)
    # in a process of its own, as in use: VTK does not get on with all other libraries
    read = subprocess.run([sys.executable, "-c", READ, path], capture_output=True, text=True)
    assert read.returncode == 0, read.stderr
    plain, *twice = np.array(json.loads(read.stdout))
    for scaled in twice:
        # displacements are written in single precision: some 1e-6 of 60 m
        assert np.abs(scaled - plain).max(axis=0) == pytest.approx([0.0, 0.0, 4.0], abs=1e-4)
        assert np.array_equal(scaled[:16], plain[:16])  # nacelle and hub
    upright = plain[16:24].mean(axis=0) - HUB_CENTRE
    assert upright[:2] == pytest.approx(29.25 * turned(1.0)[:2, 1], abs=1e-4)


def test_nearest_time_is_taken_and_others_are_refused():
    times = np.array([0.0, 0.1, 0.2])
    assert [pictures.nearest_step(times, t) for t in (0.0, 0.04, 0.06, 0.2)] == [0, 0, 1, 2]
    for t in (-0.1, 0.21):
        with pytest.raises(InputError, match=r"is outside of the run, .* from 0 s to 0\.2 s"):
            pictures.nearest_step(times, t)


@pytest.mark.parametrize(
    ("speed", "steps", "rate"), [(1.0, 101, 10.0), (6.0, 101, 60.0), (9.0, 51, 45.0)]
)
def test_movie_runs_at_its_speed_with_at_most_60_frames_a_second(speed, steps, rate):
    found = pictures.movie_steps(np.linspace(0.0, 10.0, 101), speed)
    assert (len(found[0]), found[1]) == (steps, pytest.approx(rate))


def test_movie_needs_two_times():
    with pytest.raises(InputError, match="two times or more"):
        pictures.movie_steps([0.0], 1.0)


@needs_pyvista
def test_pictures_of_several_times_share_their_colours(tmp_path):
    path = turbine(tmp_path / "fields.xdmf", (0.0, 0.5, 1.0))
    done = []
    first, last = drawing(
        pictures.render_times,
        path,
        tmp_path,
        [0.0, 1.0, 0.9],
        done=lambda: done.append(1),
    )
    assert [first.name, last.name] == ["turbine_t0.png", "turbine_t1.png"]
    assert len(done) == 2
    before, after = pixels(first), pixels(last)
    assert before.shape == (SIZE[1], SIZE[0], 3)
    white = (after > 252).all(axis=-1)
    assert white[:, :40].all()
    assert 0.02 < 1.0 - white.mean() < 0.4
    legend = np.s_[1280:1400, 700:1180]
    assert (before[legend] == after[legend]).all()  # the same numbers on the same colours
    assert len(np.unique(after[legend].reshape(-1, 3), axis=0)) > 100
    # without stress all blades are violet; then the last has the largest stress of all pictures,
    # the first half of it; 6000 is a shade lighter or darker
    for colour in ((253, 231, 37), (33, 145, 140)):  # ends and middle of viridis
        far = [((p[:1000] - colour) ** 2).sum(axis=-1).min() for p in (before, after)]
        assert far[1] < 6000 < far[0]


@needs_pyvista
@pytest.mark.parametrize(
    "look", [Look(scalar=None, view="front"), Look(scalar="displacement", scale=4.0, view="side")]
)
def test_every_look_shows_something(tmp_path, look):
    path = turbine(tmp_path / "fields.xdmf")
    png = drawing(pictures.render_turbine, path, tmp_path / "turbine.png", look=look)
    assert 0.02 < (pixels(png) < 250).any(axis=-1).mean() < 0.4


@needs_pyvista
@needs_ffmpeg
def test_movie_has_a_frame_for_every_time(tmp_path):
    import imageio_ffmpeg

    path = turbine(tmp_path / "fields.xdmf", (0.0, 0.5, 1.0))
    done = []
    mp4 = drawing(pictures.render_movie, path, tmp_path / "a.mp4", 2.0, done=lambda: done.append(1))
    assert len(done) == 3
    frames = imageio_ffmpeg.read_frames(str(mp4))
    meta = next(frames)
    assert (meta["size"], meta["fps"]) == (SIZE, 4.0)
    shown = [np.frombuffer(frame, np.uint8).astype(int) for frame in frames]
    assert len(shown) == 3
    assert np.abs(shown[2] - shown[0]).max() > 100  # it moves


@needs_pyvista
@pytest.mark.parametrize(
    ("look", "message"),
    [
        (Look(scalar="heat"), "no field 'heat', but cauchy_stress_norm, displacement, part$"),
        (Look(view="above"), "there is no view 'above', but oblique, front, side$"),
    ],
)
def test_what_cannot_be_drawn_is_one_sentence(tmp_path, look, message):
    path = turbine(tmp_path / "fields.xdmf")
    with pytest.raises(InputError, match=message) as caught:
        pictures.render_turbine(path, tmp_path / "turbine.png", look=look)
    assert "\n" not in str(caught.value)


STRICT = """
import json, sys, pyvista
from turbine_fenicsx import scene
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
