"""How names, numbers and texts are shown to people, and kept from harm.

    names: the nearest right name;  formatting: numbers, units, tables;  plain: hidden characters
"""
