"""The outcome of a run as one self-contained page.

    layout ─ triad ─ plate ─ mounting_view ─ page ─ outputs (all that a run leaves)
    noise_figure: the picture of `pipeline noise`
"""
