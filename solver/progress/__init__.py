"""Where a calibration stands: its state between generations, when it stops, and what it returns."""
