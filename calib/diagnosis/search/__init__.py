"""Sets of hypotheses that explain the rows, and their odds.

    evidence ─ table ─┬─ candidates ────────┐
    raw_columns ──────┴─ table_at, sizes ───┼─ search ─ posterior
                                     refit ─┘

``raw_columns``  what every hypothesis would leave in the rows
``evidence``     log density of the residual under a set, in closed form
``table``        every hypothesis at one solution
``table_at``     the making of that table
``candidates``   which sets are weighed: all small ones, and those beside a solution
``sizes``        what the rows ask of an effect, and whether nature has so much of it
``refit``        a set of effects added to the fit and everything refitted
``search``       screened, refitted, weighed again: from the base to the sets that explain
``posterior``    probabilities of sets, effects and classes of effects
"""
