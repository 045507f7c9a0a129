"""A formula for an error that no listed effect has.

    grammar    every formula of physics that is tried, as an effect with an expression
    discover   which of them the poses show, judged on poses that took no part
"""
