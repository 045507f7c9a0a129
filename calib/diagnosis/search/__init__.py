"""Sets of hypotheses that explain the rows, and their odds.

    evidence ─ table ─┬─ candidates ────────┐
                      └─ table_at ──────────┼─ search ─ posterior
                                     refit ─┘

``evidence``     log density of the residual under a set, in closed form
``table``        every hypothesis at one solution
``table_at``     the making of that table
``candidates``   which sets are weighed: all small ones, and those beside a solution
``refit``        a set of effects added to the fit and everything refitted, of sizes in nature
``imitation``    an unknown function in the place of an effect that it looks like
``search``       screened, refitted, weighed again: from the base to the sets that explain
``posterior``    probabilities of sets, effects and classes of effects
"""
