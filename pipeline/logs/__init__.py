"""Conversion of log files to arrays, and back.

    text ─ columns ─ read ─ ImuLog        write: a corrected log as a table
"""
