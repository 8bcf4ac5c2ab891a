"""Commands that calculate here, or read what was calculated here."""
