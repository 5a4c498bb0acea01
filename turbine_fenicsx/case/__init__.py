"""The engine of case files: tables, quantities, mistakes, files; it knows no key."""
