"""python -m mutation: no module of this name is imported again by the processes it starts."""

import sys

from validation.mutation.run import main

sys.exit(main())
