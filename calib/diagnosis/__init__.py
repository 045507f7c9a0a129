"""A fit and its residuals to a verdict: what does the model miss?

    fit ─ hypotheses ─ search ─ next_measurement ─ verdict ─ finding ─ diagnose ─ Diagnosis

``hypotheses``        everything that could be missing, and what it would leave in the residual
``search``            which sets of hypotheses explain the rows, with what odds
``next_measurement``  the poses that would settle what these leave open
``verdict``           what is named, how it ranks, and how it is said
``finding``           the verdict on one fit
``averaged``          what the parameters hold of all that is credible, for their sds
``diagnose``          the way through these rooms
``unseen``            what effects that no residual shows do to the parameters, if they are typical
``seen``              the verdict with what it rests on where poses are blind or turn with a plate
``untested``          the verdict where the noise of the poses is not known
``constants``         every number that is decided by, with its origin
"""
