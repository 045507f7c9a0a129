"""Rows of the tables that the study of the diagnosis prints."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from tests.recorded_blocks import Settled
from tests.set_trials import SetOutcome, reliability
from tests.trials import Outcome


def share(values: Sequence[bool]) -> float:
    return float(np.mean(values))


def verdict_counts(found: Sequence[Outcome]) -> str:
    return ", ".join(f"{k} {v}" for k, v in Counter(o.verdict for o in found).most_common())


HEAD = (
    f"{'hidden':26s} size trials visible first named wrong   rms -> after (90 %)   loo (90 %)  "
    f"2-sigma  verdicts"
)


def table_row(name: str, size: float, found: Sequence[Outcome]) -> str:
    named = [o for o in found if o.named] or found
    held, stated = sum(o.held for o in found), sum(o.stated for o in found)
    after, loo = [o.rms_after for o in named], [o.loo_after for o in named]
    interval = f"{held / stated:6.3f}" if stated else "     -"
    return (
        f"{name:26s} {size:4g} {len(found):6d} {share([o.visible for o in found]):7.3f} "
        f"{share([o.first for o in found]):5.3f} {share([o.named for o in found]):5.3f} "
        f"{share([o.named_wrong for o in found]):5.3f} "
        f"{np.mean([o.rms_before for o in found]):6.2f} -> {np.mean(after):5.2f} "
        f"({np.quantile(after, 0.9):5.2f})  {np.mean(loo):5.2f} ({np.quantile(loo, 0.9):5.2f}) "
        f"{interval}   {verdict_counts(found)}"
    )


def settled_row(name: str, size: float, found: Sequence[Settled]) -> str:
    advised = [s for s in found if s.block is not None]
    right = share([s.right for s in advised]) if advised else float("nan")
    blocks = ", ".join(f"{k} {v}" for k, v in Counter(s.block for s in found).most_common())
    return (f"{name:26s} {size:4g}: {len(found)} open, {len(advised)} with a block to record, "
            f"settled {right:.3f}; {blocks}")


def set_text(found: Sequence[SetOutcome], sound: Sequence[SetOutcome]) -> str:
    """Shares of sessions with hidden effects, and of the same sessions with nothing hidden."""
    visible = sum(len(o.visible) for o in found) or 1
    total = {key: sum(len(getattr(o, key)) for o in found) / visible
             for key in ("named", "single", "offered")}
    return (f"{len(found)} sessions, {visible} visible effects: named as a class "
            f"{total['named']:.3f}, as one {total['single']:.3f}, named or offered "
            f"{total['offered']:.3f}; a wrong name in {share([bool(o.wrong) for o in found]):.4f}; "
            f"{Counter(o.verdict for o in found).most_common()}\n"
            f"the same sessions with nothing hidden: "
            f"{Counter(o.verdict for o in sound).most_common()}; stated, over both halves:\n"
            f"{reliability([*found, *sound])}")
