# The core, one file for each concept, in the order of the data.

cimport numpy as cnp

cnp.import_array()

include "build.pxi"
include "placeholder.pxi"
