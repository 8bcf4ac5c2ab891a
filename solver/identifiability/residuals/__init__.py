"""Whether the model describes the data: tests of what it leaves over."""
