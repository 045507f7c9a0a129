"""Which sets of hypotheses explain the rows, and with what odds.

    raw_columns ─ table_at ─┐
    evidence ─ table ─┬─────┴─ set_densities, beside ─┬─ sets ─ expansion ─ classes ─ odds
                      └─ sizes                 refit ─┘

``raw_columns``    what every hypothesis would leave in the rows
``evidence``       log density of the residual under a set, in closed form
``table``          every hypothesis at one solution
``table_at``       the making of that table
``set_densities``  the evidence of sets of a table
``beside``         every hypothesis beside a set, and every pair
``sizes``          what the rows ask of an effect, and whether nature has so much of it
``refit``          a set of effects added to the fit and everything refitted
``sets``           the sets that were weighed, with their refits
``expansion``      the search: singles, pairs, then one more, one less or one exchanged
``classes``        effects that these poses do not separate
``odds``           probabilities of sets, effects and classes of effects
"""
