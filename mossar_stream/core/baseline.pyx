"""The core for any processor."""
include "core.pxi"
