"""What README and documentation say is true: blocks, commands, pictures and links."""
