"""The report as a live page: a tick asks Python for the exact refit, and the screen can be saved.

    state ─ live_refits ─ application ─ folder_page

The page is ``report.html`` as written by a run; its requests are answered from the configuration
and the logs beside it. Files on disk are authoritative: a run in a terminal updates the page.
"""
