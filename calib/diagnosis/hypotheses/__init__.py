"""Everything that could be missing, and its signature in the residual.

    columns, signature ─ filmed ─ listed ─ courses, unlisted

``columns``    logged columns that may cause an error
``signature``  the visible part of an effect beside a fitted model
``filmed``     a plate that drifts between the clips of its settings
``listed``     a hypothesis; those that a model can hold by a name
``courses``    those of the catalogue that are weighed by their course over the poses; bad poses
``unlisted``   unknown functions, which no catalogue has
"""
