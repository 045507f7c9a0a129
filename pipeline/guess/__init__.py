"""Logs of unknown tools: what their columns, units and clocks are, and a configuration that runs.

    raw_tables ─ header_words ─ columns ─ magnitudes, clocks ─ TableGuess ─ session ─ config_text
"""
