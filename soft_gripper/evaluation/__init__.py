"""Evaluation of recordings: averages over steady states, tables, figures, and the claims of the paper."""
