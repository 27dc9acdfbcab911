"""Tables of a run are parsable, and complete to the last digit that matters."""

import csv

import numpy as np

from contactfem.output.tables import interface_csv


def test_interface_table_keeps_its_digits(table):
    lines = list(csv.DictReader(interface_csv(table).splitlines()))
    assert len(lines) == 61
    for name, values in (
        ("X [m]", table.X[:, 0]),
        ("y [m]", table.x[:, 1]),
        ("pressure [Pa]", table.pressure),
        ("traction [Pa]", table.traction),
        ("gap [m]", table.gap),
        ("cover", table.coverage),
    ):
        found = [float(line[name]) for line in lines]
        assert np.allclose(found, values, rtol=1e-14, atol=0.0), name
    words = [line["status"] for line in lines]
    assert (words[0], words[30], words[12]) == ("open", "stick", "slip")
