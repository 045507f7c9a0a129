"""Many sensors: sessions on Dask or one table of pose means, and the statistics of the lot.

    sessions (the files) ─ worker (input_digest) ─ cluster ─┐
                                                            ├─ finish: table, population, page
    lot_table (rows of poses) ─ lot_sets ─ lot_run ─────────┘
"""
