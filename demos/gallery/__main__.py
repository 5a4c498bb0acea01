"""The pictures of ``docs/gallery.md`` and of the README, and that page.

``python demos/gallery`` draws all of them into ``docs/images``, in some twenty minutes, ``python
demos/gallery NAME ...`` those named. Each is of a run that is made for it. PyVista, Matplotlib and
imageio-ffmpeg must be there (``pip install '.[plot]'``).
"""

import argparse
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent / "verification"))

from cases import CASES, spin_up  # noqa: E402
from gallery_page import markdown  # noqa: E402
from verification import BENCHMARKS  # noqa: E402

PICTURES = {"spin_up": spin_up, **CASES, **BENCHMARKS}


def main() -> None:
    """Draw pictures and write the page."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("names", metavar="NAME", nargs="*", help="pictures to draw; default: all")
    parser.add_argument("-o", "--out", type=Path, default=HERE.parents[1] / "docs", help="folder")
    options = parser.parse_args()
    unknown = set(options.names) - set(PICTURES)
    if unknown:
        parser.error(f"there is no {', '.join(sorted(unknown))}, but {', '.join(PICTURES)}")
    folder = options.out / "images" / "gallery"
    folder.mkdir(parents=True, exist_ok=True)
    for name in options.names or PICTURES:
        print(name, flush=True)
        with tempfile.TemporaryDirectory() as scratch:
            PICTURES[name](name, Path(scratch), folder / f"{name}.png")
    (options.out / "gallery.md").write_text(markdown(), encoding="utf-8")


if __name__ == "__main__":
    main()
