"""The complete correction as source code: one set of formulas, three languages.

    formulas ─ routine ─ syntax ─ c, python, matlab
"""
