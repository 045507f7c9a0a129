"""Sets of hypotheses that explain the rows, and their odds.

    evidence ─ table ─┬─ candidates ─ what_errs ──────┐
                      └─ table_at ────────────────────┼─ search ─ posterior
                                       refit ─ entry ─┘

``evidence``     log density of the residual under a set, in closed form
``table``        every hypothesis at one solution
``table_at``     the making of that table
``candidates``   which sets are weighed: all small ones, and those beside a solution
``refit``        a set of effects added to the fit and everything refitted, of sizes in nature
``entry``        a set with what it weighs, a class with its probability
``what_errs``    what of the reading an unknown function is: the bias, the gain
``imitation``    an unknown function in the place of an effect that it looks like
``search``       screened, refitted, weighed again: from the base to the sets that explain
``posterior``    probabilities of sets, effects and classes of effects
"""
