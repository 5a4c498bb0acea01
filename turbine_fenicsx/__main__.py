"""``python -m turbine_fenicsx``."""

import sys

from turbine_fenicsx.cli.main import main

sys.exit(main())
