"""Which sets of hypotheses explain the rows, and with what odds.

    joint_conditions ─ raw_columns ─ stacked_tables ─┐
    evidence ─ table ─┬─ set_densities, beside ──────┼─ steps ─┬─ sets ─ expansion ─ classes ─ odds
                      └─ sizes          refit ───────┘         └─ together

``joint_conditions``  what effects are evaluated on at the solutions of several fits
``raw_columns``       what every hypothesis would leave in the rows
``evidence``          log density of the residual under a set, in closed form
``table``             every hypothesis at one solution
``stacked_tables``    tables at many solutions of one shape, made together
``set_densities``     the evidence of sets of many tables
``beside``            every hypothesis beside a set, and every pair
``sizes``             what the rows ask of an effect, and whether nature has so much of it
``refit``             a set of effects added to the fit and everything refitted
``steps``             what a search asks for on its way, and the answers
``together``          many searches, asking and answered together
``sets``              the sets that were weighed, with their refits
``expansion``         the search: singles, pairs, then one more, one less or one exchanged
``classes``           effects that these poses do not separate
``odds``              probabilities of sets, effects and classes of effects
"""
