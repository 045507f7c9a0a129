"""A formula for an error that no listed effect has.

    grammar    every physical formula that is tried, as an effect with an expression
    discover   the formula that the poses support, judged on left-out poses
"""
