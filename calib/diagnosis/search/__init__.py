"""Which sets of hypotheses explain the rows, and with what odds.

    evidence ─ table ─┬─ sizes, sets ─ expansion ─ odds
             refit ───┘

``evidence``   log density of the residual under a set, in closed form
``table``      every hypothesis at one solution, and the evidence of any set of them
``refit``      a set of effects added to the fit and everything refitted
``sizes``      what the rows ask of an effect, and whether nature has so much of it
``sets``       the sets that were weighed, with their refits
``expansion``  the search: singles, pairs, then one more, one less or one exchanged
``odds``       probabilities of sets, effects and classes of effects
"""
