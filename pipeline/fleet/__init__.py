"""Many sessions: whole runs on Dask, one table of them all, and what the lot shows.

    sessions (the files) ─ input_digest (what a result is of) ─ record (what a session leaves)
        └─ worker: one session ─ cluster: all of them, on Dask
                                    └─ table: rows, Parquet and CSV
"""
