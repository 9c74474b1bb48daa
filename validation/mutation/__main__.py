"""python -m mutation: no module of this name is imported again by the processes it starts."""

import sys

from mutation.run import main

sys.exit(main())
