"""The report served alive: a tick asks Python for the exact refit, and the screen can be written.

    state ─ live_refits ─ application ─ folder_page

The page is ``report.html`` as a run has written it; what it asks is answered from the
configuration and the logs beside it. Files on disk are the truth: a run in a terminal updates the
page.
"""
