"""What a reading may err by: each effect is a set of columns.

    effect ── base, nonlinear, environment, motion, reference ──┐
       │        (one function with a page for each effect)      ├─ catalogue: every effect by name
       ├─ needs: what of it some poses lack; variation: what the base does not hold
       └─ expression ─ user_defined (or a Python function) ─────┘
"""
