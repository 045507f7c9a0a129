"""What a guided recording says of a block and of a pose, in words."""

from calib.poses.runs.ideal_ring import ADVISED_TILT
from pipeline.record.block_files import RecordingBlock
from pipeline.record.stream import Stream, TimedSample
from pipeline.text.formatting import count

LOST_SHARE = 0.02  #: share of a pose's samples from which the loss is reported


def introduction(block: RecordingBlock, missing: int, recorded: int) -> str:
    """What a block asks for, in a line."""
    so_far = f", {recorded} are recorded" if recorded else ""
    where = f"on the plate turning at '{block.rate}'" if block.turns else "with the plate stopped"
    where += f", with {ADVISED_TILT}" if block.leans else ""
    return (f"{count(missing, 'pose')} of {block.seconds:g} s {where}{so_far}. Ctrl-C stops; "
            f"nothing is lost.")


def loss_of(rows: list[TimedSample], stream: Stream) -> str:
    """What to say of samples lost within a pose; empty where it is nothing."""
    first, last = rows[0].ticks, rows[-1].ticks
    clock, rate_hz = stream.parser.clock, stream.rate_hz
    if first is None or last is None or clock is None or rate_hz is None:
        return ""
    sent = last - first + 1 if clock.tick_s is None else (last - first) * clock.tick_s * rate_hz + 1
    share = 1 - len(rows) / sent
    return f"; {100 * share:.0f} % of its samples were lost" if share > LOST_SHARE else ""
