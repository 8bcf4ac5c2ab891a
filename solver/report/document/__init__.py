"""The report: what stands in it, as HTML and PDF."""
