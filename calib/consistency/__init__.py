"""What one part of a session knows that contradicts another.

    logs ─ repeats ─ clock ─────┐                               same samples twice, whole turns
    poses ─ force ─ plate_axes ─┼─ mistakes ─ contradiction     gravity, axes of both triads, runs
    parameters ─ data_sheet ────┘

Each check compares two statements of one quantity and names the likely mistake: it evaluates what
the data would be without each of a list of common mistakes (axes exchanged or mirrored, a factor,
another run's rate) and says which of them ends the contradiction.
"""
