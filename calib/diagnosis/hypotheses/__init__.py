"""Everything that could be missing, and what it would leave in the residual.

    columns, signature ─ listed ─ unlisted

``columns``    which logged columns may cause an error
``signature``  what of an effect is visible beside a fitted model
``listed``     a hypothesis; those that a model can hold by a name
``unlisted``   those that no model can hold: unknown functions, steps, bad poses, a wandering bias
"""
