"""Readers of files that are not one table of text, each using the library of its format.

    kinds: the format of a file, by its first bytes ─ one module per format ─ FileTable

A module is imported when a file of its format is read. Formats that state their units (ROS, PX4,
ArduPilot) give our columns in SI units; the others give columns with the names in the file.
"""
