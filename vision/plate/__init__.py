"""Where the plate is and what it looks like.

    background, rotation ─ detect ─┐
    channel, polar, mark, symmetry ┴─ template ─ view_refinement ─ learn (or refusal)
"""
