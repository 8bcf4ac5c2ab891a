"""What a worker does: claims evaluations, runs them within their limits, hands them in."""
