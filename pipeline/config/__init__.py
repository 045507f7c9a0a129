"""From YAML to a checked configuration, and edits of the file that keep its comments.

    yaml_syntax ─ yaml_text ─ schema (types, file_patterns, units) ─ session ─ rules ─ load
                     └─ edit                    messages: every mistake, with line and remedy
"""
