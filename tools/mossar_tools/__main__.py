"""`python -m mossar_tools` is `mossar`."""

import sys

from mossar_tools.cli import main

sys.exit(main())
