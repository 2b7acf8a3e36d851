"""Frame and meta maps: what ZeroMQ, JSON lines and `.msk` files carry, and the one decoder for all of them."""
