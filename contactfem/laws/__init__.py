"""The laws at a point: contact, friction, conductance, frictional heat."""
