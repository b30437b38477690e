"""The estimators of the shape side by side, on the recordings of the paper's scenarios."""
