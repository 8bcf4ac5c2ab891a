"""Commands to begin with: starters, examples, the demonstration, the published study."""
