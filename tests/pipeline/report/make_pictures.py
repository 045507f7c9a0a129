"""Makes the pictures of README from the tutorial's session: ``python -m
tests.pipeline.report.make_pictures [FOLDER]``; by default into ``data/docs``."""

import base64
import io
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

from PIL import Image

from tests.paths import DATA
from tests.pipeline.report.tab import Tab, started_browser
from tests.pipeline.workbench.conftest import opened_workbench
from tests.sessions import pipeline

SCREEN = {"width": 1120, "height": 900, "deviceScaleFactor": 1, "mobile": False}
ROOM = 12  #: px about the elements of a picture
COLOURS = 128  #: of a picture, which make it a third as large
SESSION = "hidden_effect"
MOVING_WIDTH, MOVING_HEIGHT = 760, 625  #: px: of the moving picture, and of what it shows
STAYS_MS, MOVE_MS = 1800, 80  #: a frame before and after the tick, and one between
SLOWER = 0.3  #: than on the page the marks move while they are photographed
MOVES_S = 1.8  #: as long as the marks move so
TICK = "#gyroscope input[data-effect=g_sensitivity]"

#: Of every picture the elements that it reaches from and to.
PICTURES = {
    "report_verdict": ("header", ".answers .lead"),
    "report_axes": ("#gyroscope .axes", "#gyroscope .axes"),
}
#: Of the workbench, with the tick.
WORKBENCH = {"workbench": ("#gyroscope [data-bench]", "#gyroscope [data-bench-gain-words]")}


def picture(tab: Tab, first: str, last: str) -> bytes:
    """The page from one element to another over the whole width, as a PNG."""
    top, bottom = tab.evaluate(
        "const at = (selector) => document.querySelector(selector).getBoundingClientRect();"
        f"return [at('{first}').top + scrollY, at('{last}').bottom + scrollY];")
    clip = {"x": 0, "y": top - ROOM, "width": SCREEN["width"], "height": bottom - top + 2 * ROOM,
            "scale": 1}
    data = tab.send("Page.captureScreenshot", format="png", clip=clip, captureBeyondViewport=True)
    image = Image.open(io.BytesIO(base64.b64decode(data["data"]))).convert("RGB")
    packed = io.BytesIO()
    image.quantize(COLOURS, dither=Image.Dither.NONE).save(packed, "PNG", optimize=True)
    return packed.getvalue()


def moving_picture(tab: Tab) -> bytes:
    """A tick in the tutorial's page as an animated GIF: the residuals go into the noise."""
    tab.send("Emulation.setEmulatedMedia",
             features=[{"name": "prefers-reduced-motion", "value": "no-preference"}])
    tab.send("Animation.enable")
    tab.send("Animation.setPlaybackRate", playbackRate=SLOWER)
    x, y, width, height = tab.evaluate(
        "const b = document.querySelector('#gyroscope .refit').getBoundingClientRect();"
        f"return [b.x, b.y + scrollY, b.width, {MOVING_HEIGHT}];")
    tab.evaluate(f"window.scrollTo({{top: {y - ROOM}, behavior: 'instant'}})")
    tab.painted()
    clip = {"x": x, "y": y, "width": width, "height": height, "scale": MOVING_WIDTH / width}

    def shown() -> Image.Image:
        data = tab.send("Page.captureScreenshot", format="png", clip=clip)["data"]
        return Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB")

    frames = [shown()]
    tab.evaluate(f"document.querySelector('{TICK}').click()")
    start = time.monotonic()
    while time.monotonic() - start < MOVES_S:
        frames.append(shown())
    frames.append(shown())
    ends = Image.new("RGB", (frames[0].width, 2 * frames[0].height))
    ends.paste(frames[0], (0, 0))
    ends.paste(frames[-1], (0, frames[0].height))
    palette = ends.quantize(COLOURS // 2, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    still = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    packed = io.BytesIO()
    still[0].save(packed, "GIF", save_all=True, append_images=still[1:], loop=0, optimize=True,
                  duration=[STAYS_MS, *[MOVE_MS] * (len(still) - 2), 2 * STAYS_MS])
    return packed.getvalue()


def make(folder: Path) -> None:
    """Run the tutorial's session beside its name in README and photograph its report."""
    with tempfile.TemporaryDirectory() as name:
        bench = Path(name)
        shutil.copytree(DATA / SESSION, bench / "data" / SESSION,
                        ignore=shutil.ignore_patterns("*.run"))
        os.chdir(bench)
        assert pipeline("run", f"data/{SESSION}/config.yaml") == 0
        with started_browser(bench) as browser, browser.tab() as tab:
            tab.open(bench / "data" / SESSION / "config.run" / "report.html", SCREEN)
            for name, (first, last) in PICTURES.items():
                (folder / f"{name}.png").write_bytes(picture(tab, first, last))
            (folder / "tick.gif").write_bytes(moving_picture(tab))
            with opened_workbench(bench / "data" / SESSION / "config.yaml") as opened:
                tab.visit(opened.address, SCREEN)
                tab.wait("document.querySelectorAll('[data-bench-normal] circle').length > 0")
                tab.click(TICK)
                tab.wait("document.querySelectorAll('#gyroscope .tried tbody tr').length > 1")
                for name, (first, last) in WORKBENCH.items():
                    (folder / f"{name}.png").write_bytes(picture(tab, first, last))


if __name__ == "__main__":
    make(Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else DATA / "docs")
