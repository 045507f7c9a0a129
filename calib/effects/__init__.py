"""Errors that a reading may have: each effect is a set of columns.

    effect ── base, nonlinear, environment, motion, reference ──┐
       │        (one function with a page for each effect)      ├─ catalogue: every effect by name
       ├─ needs: conditions that some poses lack; variation: conditions beyond the base
       └─ expression ─ user_defined (or a Python function) ─────┘
"""
