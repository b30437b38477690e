"""How soon faults of fingers and sensors are named."""
