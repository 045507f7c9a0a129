"""What stands in results.json: every key, its type, its range and its meaning.

    types ─ rate ─ triad ─ file

One declaration: :func:`pipeline.results.read.load_results` checks a file by it, and
``data/docs/results.md`` is written from it.
"""

FORMAT = 1  #: of results.json; a run writes it without loading the declarations
