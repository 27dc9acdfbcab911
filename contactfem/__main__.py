"""`python3 -m contactfem` is `contactfem`."""

from contactfem.cli import main

raise SystemExit(main())
