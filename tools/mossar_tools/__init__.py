"""Programs built on mossar-stream: command line, dashboard, evaluation, benchmark."""
