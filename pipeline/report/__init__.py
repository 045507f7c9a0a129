"""The results of a run as one self-contained page.

    page_templates ─ triad ─ plate ─ mounting_view ─ page (all that a run leaves in its folder)
    noise_figure: the picture of `pipeline noise`
"""
