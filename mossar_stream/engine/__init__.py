"""The loop around the kernels, the pools of performers, and what a performer needs."""
