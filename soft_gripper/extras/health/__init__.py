"""The health of fingers and sensors: faults named with a probability, and faulty sensors dropped."""
