"""From messages that carry a joint each to whole frames."""
