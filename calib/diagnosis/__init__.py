"""From a fit and its residuals to a verdict: which effects does the model lack?

    fit ─ hypotheses ─ search ─ next_measurement ─ verdict ─ finding ─ diagnose ─ Diagnosis

``hypotheses``        everything that could be missing, and its signature in the residual
``search``            sets of hypotheses that explain the rows, and their odds
``next_measurement``  the poses that would settle what these leave open
``verdict``           the named effects, the ranking, and the words
``finding``           the verdict on one fit
``averaged``          bias of the parameters by all credible hypotheses, for their sds
``stand_ins``         effects of the model that stand for others, and what these would change
``diagnose``          the way through these modules
``absorbed``          what the parameters hold of an effect, and what the rows show of it
``formula_error``     error of the model's formulas between the values that the poses saw
``unseen``            influence on the parameters of effects that no residual shows, if typical
``grounds``           the verdict with what it rests on: noise, blind poses, a turning plate
``constants``         every number that decides, with its origin
"""
