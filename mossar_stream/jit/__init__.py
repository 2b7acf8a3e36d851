"""The only place that knows how numba compiles."""

import numba

from mossar_stream.jit.numba_versions import warn_if_untested

warn_if_untested(numba.__version__)  # before anything of this package reaches for what a version may lack
