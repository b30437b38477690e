"""The evaluation of the paper: five scenarios, tables, figures, claims and a report."""
