"""Frame and meta maps: the content of ZeroMQ messages, JSON lines and `.msk` files, with one decoder for all."""
