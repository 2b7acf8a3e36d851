"""The core for x86-64-v3: AVX2, FMA, BMI."""
include "core.pxi"
