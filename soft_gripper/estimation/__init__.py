"""Shape, driving torque and base pose -> load, contact, width."""
