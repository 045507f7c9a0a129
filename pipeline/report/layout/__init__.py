"""What all pages share: templates, glossary, and the data that a page's script works on."""
