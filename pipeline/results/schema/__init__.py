"""What stands in results.json: every key, its type, its range and its meaning.

    types ─ rate ─ triad ─ file

One declaration: :func:`pipeline.results.read.load_results` checks a file by it, and
``data/docs/results.md`` is written from it.
"""

FORMAT = 1  #: version of results.json; raised when a key goes or changes its meaning
