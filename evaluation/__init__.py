"""What recordings say: averages over held steps, tables, figures, and the claims of the paper."""
