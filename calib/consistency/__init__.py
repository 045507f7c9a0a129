"""Checks of the parts of a session against each other.

    logs ─ raw_samples ─ repeats ─ clock ┐             frozen or cut off, same samples, turns
    poses ─ force ─ plate_axes ────────┼─ mistakes                  gravity, axes, runs
    parameters ─ data_sheet ───────────┘
    parameters ─ certificate                                        beside the factory's
    logs ─ log_units, truncation                       units; readings cut toward zero

    signed_axes: the ways to exchange and mirror axes
    common_mistakes: the poses without each mistake

Each check compares two statements of one quantity and names the likely mistake: it evaluates what
the data would be without each of a list of common mistakes (axes exchanged or mirrored, a factor,
another run's rate) and reports which of them resolves the contradiction.
"""
