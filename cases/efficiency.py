"""Two temperatures that are known: what a case needs of them, as functions of place and time."""

from contactfem.verification.manufactured import MovingGaussian, SuddenSwitch

K, CAPACITY = 0.2, 2.0  # conductivity [W/m/K], heat capacity [J/m³/K]
SPOT = MovingGaussian(K, CAPACITY)
SWITCH = SuddenSwitch(K, CAPACITY)

spot_temperature, spot_source = SPOT.theta, SPOT.source
switch_temperature, switch_source = SWITCH.theta, SWITCH.source
