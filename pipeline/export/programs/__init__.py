"""The complete correction as source code: the effects' own expressions, three languages.

    errors ─ routine ─ syntax ─ write (a template for each language)
"""
