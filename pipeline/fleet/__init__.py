"""Many sensors: sessions on Dask or one table of pose means, and the statistics of the lot.

    sessions (the files) ─ worker (input_digest, record) ─ cluster ─┐
                                                                    ├─ finish: table, population,
    lot_table (rows of poses) ─ lot_sets ─ lot_run ─────────────────┘          page, words
"""
