"""Everything that could be missing, and what it would leave in the residual.

    columns, signature ─ listed ─ courses, unlisted

``columns``    which logged columns may cause an error
``signature``  what of an effect is visible beside a fitted model
``listed``     a hypothesis; those that a model can hold by a name
``courses``    those of the catalogue that are weighed by their course over the poses; bad poses
``unlisted``   unknown functions, which no catalogue has
"""
