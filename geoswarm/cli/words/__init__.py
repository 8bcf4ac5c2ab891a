"""What commands print: tables, notes, errors, warnings."""
