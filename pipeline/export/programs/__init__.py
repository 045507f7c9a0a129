"""The complete correction as source code: the effects' own expressions, three languages.

    routine (errors, steps) ─ syntax (a template for each language)
"""
