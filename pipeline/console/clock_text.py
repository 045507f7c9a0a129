"""A camera's clock as text."""

from collections.abc import Iterator
from datetime import date

from pipeline.cameras import AGEING_PPM_PER_YEAR, CameraClock
from pipeline.text.formatting import NAME_WIDTH
from vision.rate.filmed_screen import FilmedScreen


def clock_line(clock: CameraClock, today: date) -> str:
    """``clock c920      fast by 80.2 ppm ± 4.6 ppm, measured 2026-11-23``."""
    way = "fast" if clock.fast_ppm >= 0 else "slow"
    return (f"{f'clock {clock.name}':<{NAME_WIDTH}} {way} by {abs(clock.fast_ppm):.1f} ppm ± "
            f"{clock.sd_on(today):.1f} ppm, measured {clock.measured.isoformat()}")


def clock_parts(clock: CameraClock, film: FilmedScreen) -> Iterator[str]:
    """The film, and each part of the sd."""
    yield (f"  a film of {film.seconds:.0f} s, {film.turns:.1f} turns; an angle scatters by "
           f"{1e3 * film.noise_s:.1f} ms; {film.beats:.1f} refreshes slipped through the frames")
    for part, sd in clock.parts_ppm.items():
        known = f", by {clock.how}" if part == "computer's clock" else ""
        yield f"  {part:<22} {sd:5.1f} ppm{known}"
    yield f"  {'age':<22} {AGEING_PPM_PER_YEAR:5.1f} ppm for every year from today"


def next_step(clock: CameraClock) -> str:
    """Instruction to use it in a session."""
    return f"next: write `timebase: {{camera: {clock.name}}}` beside `video:` of its clips"
