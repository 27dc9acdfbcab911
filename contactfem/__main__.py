"""`python3 -m contactfem` is `contactfem`."""

from contactfem.cli.main import main

raise SystemExit(main())
