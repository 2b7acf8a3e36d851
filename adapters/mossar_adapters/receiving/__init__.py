"""From what a wire carries to frames: admission of senders, names, times, and chunks."""
