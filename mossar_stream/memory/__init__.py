"""Where a performer's state lies: rows of bytes, and the views that kernels take of them."""
