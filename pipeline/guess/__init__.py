"""Logs of unknown tools: their columns, units and clocks, and a configuration that runs.

    raw_tables ─ header_words ─ columns ─ magnitudes, clocks ─ TableGuess ─ session ─ config_text
"""
