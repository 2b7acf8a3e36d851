"""`python -m mossar_tools` is `mossar`."""

import sys

from mossar_tools.entry import main

sys.exit(main())
