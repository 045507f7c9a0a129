"""Names, numbers and texts for people, and made safe.

    names: the nearest right name;  formatting: numbers, units;  plain: hidden characters
    wrapping: the terminal's width;  tables: columns that line up
"""
