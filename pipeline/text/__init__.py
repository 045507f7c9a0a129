"""How names, numbers and texts are shown to people, and kept from harm.

    names: the nearest right name;  formatting: numbers, units;  plain: hidden characters
    wrapping: the terminal's width;  tables: columns that line up
"""
