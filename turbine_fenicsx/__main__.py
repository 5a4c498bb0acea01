"""``python -m turbine_fenicsx``."""

import sys

from turbine_fenicsx.cli import main

sys.exit(main())
