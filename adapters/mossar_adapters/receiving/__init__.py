"""From messages of a wire to frames: admission of senders, names, times, and chunks."""
