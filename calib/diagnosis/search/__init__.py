"""Which sets of hypotheses explain the rows, and with what odds.

    raw_columns, evidence ─ table ─┬─ beside, sizes ─ sets ─ expansion ─ odds
                          refit ───┘

``raw_columns``  what every hypothesis would leave in the rows
``evidence``     log density of the residual under a set, in closed form
``table``        every hypothesis at one solution, and the evidence of any set of them
``refit``        a set of effects added to the fit and everything refitted
``beside``       every hypothesis beside a set, and every pair
``sizes``        what the rows ask of an effect, and whether nature has so much of it
``sets``         the sets that were weighed, with their refits
``expansion``    the search: singles, pairs, then one more, one less or one exchanged
``odds``         probabilities of sets, effects and classes of effects
"""
