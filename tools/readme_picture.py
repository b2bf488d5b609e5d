"""The picture of the README, made anew: `python tools/readme_picture.py`.

Runs `scenes/crystal.yaml` and takes a picture of its recording, without the viewer's bar of menus, whose warnings of a
software renderer tell of the machine at hand. Needs what `tools/screenshot.py` needs.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from PIL import Image
from screenshot import screenshot

import porous_swim as ps

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs" / "crystal.png"
STEP = 40_000  # half of the run: trails have grown
SIZE = 1600, 1036  # points
MENU = 36  # points, the height of that bar


def main() -> None:
    """Run, look, crop."""
    with tempfile.TemporaryDirectory() as folder:
        run, whole = Path(folder) / "run", Path(folder) / "whole.png"
        ps.run(ps.load_scene(ROOT / "scenes" / "crystal.yaml"), out=run, progress=True)
        screenshot(run / "recording.rrd", whole, moment=STEP, size="{}x{}".format(*SIZE))
        with Image.open(whole) as picture:
            points = picture.width / SIZE[0]
            cut = picture.crop((0, round(MENU * points), picture.width, picture.height)).convert("RGB")
        small = cut.resize((SIZE[0], SIZE[1] - MENU), Image.Resampling.LANCZOS)
        small.quantize(256, dither=Image.Dither.NONE).save(PICTURE, optimize=True)
    print(PICTURE)


if __name__ == "__main__":
    main()
